//! A sortie: what a recording says of a run in a few figures and moments.
//!
//! A [`SortieObserver`] takes the entries of a run in their order, while the run is recorded or when its
//! recording is read. Its memory is bounded.
//!
//! Engaged is the time in which the camera may follow (servoing or holding). The movements of the motor
//! schema are those that it would have made on the same bearings ([`crate::shadow`]): an estimate.

mod moment;
mod words;

use std::collections::BTreeMap;

use barrelman_control::Region;
use barrelman_pilot::Mode;
use barrelman_vocab::{Named as _, StopCause, Timestamp, Track, VehicleProfile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use moment::{Happening, Moment};
pub use words::length;

use crate::camera_work::{CameraWork, CameraWorkMeter, WorkFigures};
use crate::records::{Entry, RecordedOutcome, RecordingStart};
use crate::work_step::WorkStep;

/// Maximum number of moments that are kept; later ones are only counted in the figures.
const MAX_MOMENTS: usize = 10_000;

/// What happened in a sortie.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Sortie {
    /// Unix time of the first outcome, ns.
    pub began_unix_ns: u64,
    /// From the first outcome to the last, s.
    pub length_s: f64,
    /// Address of the video, without passwords.
    pub video: String,
    /// Address of the link; empty for a dry run.
    pub link: String,
    /// Semi-axes of the ellipse in which the camera rests, as shares of half the picture's width and height.
    pub region: [f64; 2],
    /// Time in which the camera may follow the target, s.
    pub engaged_s: f64,
    /// The part of it in which the position of the boat was known: measured (tracking), or predicted for a
    /// limited time (coasting), s.
    pub followed_s: f64,
    /// Losses of the track.
    pub losses: Spells,
    /// Why the camera rested while engaged, by key.
    pub holds: BTreeMap<String, Spells>,
    /// What stopped the camera, by key: how often. The end of the program is no stop.
    pub stops: BTreeMap<String, u64>,
    /// The movements of the camera while engaged.
    pub camera: WorkFigures,
    /// Those that the motor schema would have made.
    pub schema: WorkFigures,
    /// The moments, in the order of time.
    pub moments: Vec<Moment>,
}

/// How often and how long something lasted.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
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
    is_known: bool,
    is_lost: bool,
    /// How long the loss or the hold that lasts has lasted.
    lost_for_s: f64,
    held_for_s: f64,
    work: CameraWorkMeter,
    profile: VehicleProfile,
}

impl SortieObserver {
    /// `profile`: the vehicle, for the motor schema's movements.
    pub fn new(profile: VehicleProfile) -> Self {
        Self {
            work: CameraWorkMeter::new(&profile),
            sortie: Sortie {
                region: [profile.region.half_width, profile.region.half_height],
                ..Sortie::default()
            },
            profile,
            unix_ns: 0,
            first: None,
            last: None,
            mode: Mode::Idle,
            is_known: false,
            is_lost: false,
            lost_for_s: 0.0,
            held_for_s: 0.0,
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
            Entry::Note { at, note } => self.note(*at, Happening::Noted { text: note.text.clone() }),
            Entry::Unit(..) | Entry::Truth(_) => {}
        }
    }

    pub(crate) fn begin(&mut self, start: &RecordingStart) {
        self.unix_ns = start.unix_ns;
        self.sortie.video.clone_from(&start.videos.first.address);
        self.sortie.link.clone_from(&start.link);
    }

    /// What happened, up to the last entry.
    pub fn finish(mut self) -> Sortie {
        self.end_loss();
        self.end_hold();
        let CameraWork { camera, schema, .. } = self.work.work(None);
        (self.sortie.camera, self.sortie.schema) = (camera, schema.unwrap_or_default());
        self.sortie
    }

    fn add_outcome(&mut self, outcome: &RecordedOutcome) {
        let now = outcome.at;
        let first = *self.first.get_or_insert(now);
        let lasted_s = self.last.replace(now).map_or(0.0, |last| now.since(last).as_secs_f64());
        self.sortie.began_unix_ns = self.unix_ns.saturating_add(first.as_nanos());
        self.sortie.length_s = now.since(first).as_secs_f64();
        let was_engaged = self.mode.is_engaged();
        if was_engaged {
            self.sortie.engaged_s += lasted_s;
            self.sortie.followed_s += if self.is_known { lasted_s } else { 0.0 };
        }
        if self.is_lost {
            self.lost_for_s += lasted_s;
        }
        if matches!(self.mode, Mode::Holding(_)) {
            self.held_for_s += lasted_s;
        }
        self.change_track(now, &outcome.track);
        self.change_mode(now, outcome.mode);
        self.work.on_step(WorkStep {
            at: now,
            mode: outcome.mode,
            command: outcome.command,
            track: &outcome.track,
            percept: outcome.percept,
            region: outcome
                .track
                .localisation()
                .map(|seen| Region::from_shares(self.profile.region, seen.picture)),
        });
    }

    fn change_track(&mut self, now: Timestamp, track: &Track) {
        self.is_known = track.localisation().is_some();
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
        let (was_engaged, is_engaged) = (self.mode.is_engaged(), mode.is_engaged());
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
