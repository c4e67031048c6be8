//! A sortie: what a recording says of a run in a few figures and moments.
//!
//! A [`SortieObserver`] takes the entries of a run in their order, while the run is recorded or when its
//! recording is read. Its memory is bounded.
//!
//! Engaged is the time in which the camera may follow (servoing or holding). The movements of the motor schema
//! are those that it would have made on the same bearings ([`crate::shadow`]): an estimate.

mod moment;

mod movements;

use std::collections::BTreeMap;

use barrelman_control::{CameraModel, LawInput, Region, ShadowController};
use barrelman_pilot::Mode;
use barrelman_vocab::{CameraCommand, Named as _, StopCause, Timestamp, Track, VehicleProfile};
use serde::{Deserialize, Serialize};

pub use moment::{Happening, Moment};
pub use movements::Movements;

use crate::records::{Entry, RecordedOutcome, RecordingStart};
use movements::MovementCounter;

/// Maximum number of moments that are kept; later ones are only counted in the figures.
const MAX_MOMENTS: usize = 10_000;

/// What happened in a sortie.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Sortie {
    /// Unix time of the first outcome, ns.
    pub began_unix_ns: u64,
    /// From the first outcome to the last, s.
    pub length_s: f64,
    /// Address of the video, without passwords.
    pub video: String,
    /// Address of the link; empty for a dry run.
    pub link: String,
    /// Time in which the camera may follow the target, s.
    pub engaged_s: f64,
    /// The part of it in which the position of the target was known, s.
    pub followed_s: f64,
    /// Losses of the track.
    pub losses: Spells,
    /// Why the camera rested while engaged, by key.
    pub holds: BTreeMap<String, Spells>,
    /// What stopped the camera, by key: how often. The end of the program is no stop.
    pub stops: BTreeMap<String, u64>,
    /// The movements of the camera while engaged.
    pub camera: Movements,
    /// Those that the motor schema would have made; `None` where the vehicle is not known.
    pub schema: Option<Movements>,
    /// The moments, in the order of time.
    pub moments: Vec<Moment>,
}

/// How often and how long something lasted.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Spells {
    /// How often.
    pub count: u64,
    /// All of them together, s.
    pub total_s: f64,
    /// The longest, s.
    pub longest_s: f64,
}

/// Watches a run.
#[derive(Debug)]
pub struct SortieObserver {
    sortie: Sortie,
    unix_ns: u64,
    first: Option<Timestamp>,
    last: Option<Timestamp>,
    mode: Mode,
    is_lost: bool,
    /// How long the loss or the hold that lasts has lasted.
    lost_for_s: f64,
    held_for_s: f64,
    camera: MovementCounter,
    schema: Option<Schema>,
}

/// The motor schema on the bearings of the target.
#[derive(Debug)]
struct Schema {
    camera: CameraModel,
    controller: ShadowController,
    profile: VehicleProfile,
    counter: MovementCounter,
    command: CameraCommand,
}

impl SortieObserver {
    /// `profile`: the vehicle, for the motor schema's movements.
    pub fn new(profile: Option<VehicleProfile>) -> Self {
        let schema = profile.map(|profile| Schema {
            camera: CameraModel::new(profile.camera, profile.limits),
            controller: ShadowController::new(&profile),
            counter: MovementCounter::default(),
            command: CameraCommand::REST,
            profile,
        });
        Self {
            sortie: Sortie::default(),
            unix_ns: 0,
            first: None,
            last: None,
            mode: Mode::Idle,
            is_lost: false,
            lost_for_s: 0.0,
            held_for_s: 0.0,
            camera: MovementCounter::default(),
            schema,
        }
    }

    /// Takes the next entry.
    pub fn add(&mut self, entry: &Entry) {
        match entry {
            Entry::Start(start) => self.begin(start),
            Entry::Input { now, input, .. } => {
                let request = input.request();
                if let Some(what) = request.and_then(Happening::of_request) {
                    self.note(*now, what);
                }
            }
            Entry::Outcome(outcome) => self.add_outcome(outcome),
            Entry::Unit(_) | Entry::Truth(_) => {}
        }
    }

    pub(crate) fn begin(&mut self, start: &RecordingStart) {
        self.unix_ns = start.unix_ns;
        self.sortie.video.clone_from(&start.video);
        self.sortie.link.clone_from(&start.link);
    }

    /// What happened, up to the last entry.
    pub fn finish(mut self) -> Sortie {
        self.end_loss();
        self.end_hold();
        self.sortie.camera = self.camera.movements();
        self.sortie.schema = self.schema.map(|schema| schema.counter.movements());
        self.sortie
    }

    fn add_outcome(&mut self, outcome: &RecordedOutcome) {
        let now = outcome.at;
        let first = *self.first.get_or_insert(now);
        let lasted_s = self.last.replace(now).map_or(0.0, |last| now.since(last).as_secs_f64());
        self.sortie.began_unix_ns = self.unix_ns.saturating_add(first.as_nanos());
        self.sortie.length_s = now.since(first).as_secs_f64();
        let was_engaged = is_engaged(self.mode);
        if was_engaged {
            self.sortie.engaged_s += lasted_s;
            self.sortie.followed_s += if self.is_lost { 0.0 } else { lasted_s };
        }
        if self.is_lost {
            self.lost_for_s += lasted_s;
        }
        if matches!(self.mode, Mode::Holding(_)) {
            self.held_for_s += lasted_s;
        }
        self.change_track(now, &outcome.track);
        self.change_mode(now, outcome.mode);
        let is_engaged = is_engaged(outcome.mode);
        let in_force = outcome.rates.in_the_senses_of(outcome.command);
        self.camera.add(lasted_s, if is_engaged { in_force } else { CameraCommand::REST });
        if let Some(schema) = &mut self.schema {
            schema.add(lasted_s, outcome, in_force, is_engaged);
        }
    }

    fn change_track(&mut self, now: Timestamp, track: &Track) {
        match track {
            Track::Lost { .. } if !self.is_lost => {
                self.is_lost = true;
                self.note(now, Happening::Lost);
            }
            Track::Tracking(_) | Track::Unseeded if self.is_lost => {
                self.end_loss();
                if matches!(track, Track::Tracking(_)) {
                    self.note(now, Happening::Found);
                }
            }
            Track::Lost { .. } | Track::Tracking(_) | Track::Unseeded | Track::Coasting(_) => {}
        }
    }

    fn change_mode(&mut self, now: Timestamp, mode: Mode) {
        if mode == self.mode {
            return;
        }
        self.end_hold();
        let (was_engaged, is_engaged) = (is_engaged(self.mode), is_engaged(mode));
        match mode {
            Mode::Stopped(cause) => {
                if cause != StopCause::Ending {
                    *self.sortie.stops.entry(cause.key().to_owned()).or_default() += 1;
                }
                self.note(now, Happening::Stopped { cause });
            }
            _ if is_engaged && !was_engaged => self.note(now, Happening::Engaged),
            _ if was_engaged && !is_engaged => self.note(now, Happening::Disengaged),
            _ => {}
        }
        self.mode = mode;
    }

    fn end_loss(&mut self) {
        if std::mem::take(&mut self.is_lost) {
            self.sortie.losses.add(std::mem::take(&mut self.lost_for_s));
        }
    }

    fn end_hold(&mut self) {
        if let Mode::Holding(cause) = self.mode {
            let lasted_s = std::mem::take(&mut self.held_for_s);
            self.sortie.holds.entry(cause.key().to_owned()).or_default().add(lasted_s);
        }
    }

    fn note(&mut self, at: Timestamp, what: Happening) {
        if self.sortie.moments.len() < MAX_MOMENTS {
            let at_s = self.first.map_or(0.0, |first| at.since(first).as_secs_f64());
            self.sortie.moments.push(Moment { at_s, what });
        }
    }
}

impl Spells {
    fn add(&mut self, lasted_s: f64) {
        self.count += 1;
        self.total_s += lasted_s;
        self.longest_s = self.longest_s.max(lasted_s);
    }
}

impl Schema {
    fn add(&mut self, lasted_s: f64, outcome: &RecordedOutcome, in_force: CameraCommand, is_engaged: bool) {
        let (now, profile) = (outcome.at, &self.profile);
        let looked_at = outcome.percept.zip(outcome.track.localisation()).filter(|_| outcome.age.is_some());
        if let Some((percept, localisation)) = looked_at {
            let picture = localisation.picture;
            let region = Region::from_shares(profile.region, picture);
            let captured = now.minus(profile.video_latency);
            let input = LawInput { percept: &percept, region, picture, captured, is_measured: true, now };
            self.command = self.controller.step(&input, &self.camera).command;
        }
        self.camera.apply_command(in_force, now);
        self.counter.add(lasted_s, if is_engaged { self.command } else { CameraCommand::REST });
    }
}

/// Whether the camera may follow the target.
const fn is_engaged(mode: Mode) -> bool {
    match mode {
        Mode::Servoing | Mode::Holding(_) => true,
        Mode::Idle | Mode::Nudging | Mode::Searching | Mode::Calibrating | Mode::Stopped(_) => false,
    }
}
