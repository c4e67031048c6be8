//! One simulated trial, in lock step.
//!
//! ```text
//!   World --truth--> Sensor or Eye --latency--> Pilot::step --command--> the door --> World
//! ```
//! Time is the world's ticks. A picture that is taken at one tick reaches the pilot some ticks later, or never, as the
//! video link has it; a command reaches the camera in the tick in which the pilot gave it. Between two pictures the
//! pilot is stepped when it asked to be.

use std::collections::VecDeque;

use barrelman_pilot::{Input, Outcome, Pilot};
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::camera_mount::TICKS_PER_TILT_REPORT;
use barrelman_sim::video_link::{Delivery, VideoLink};
use barrelman_sim::world::{Truth, World};
use barrelman_sim::{LocalisationSensor, Scenario};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{
    Localisation, OperatorRequest, PixelBox, Telemetry, Timestamp, Track, VehicleProfile, VehicleRates,
    VideoFrame,
};

use crate::logs::{LogRow, RowTruth, TrialLog};

/// Who draws what the camera sees, for trials in pixels.
pub trait Eye {
    /// Draws the world as it is now.
    fn look(&mut self, world: &World) -> View;
    /// What comes of a picture on its way to the pilot: itself, unless a codec works on it.
    fn receive(&mut self, view: &View) -> VideoFrame {
        view.frame.clone()
    }
}

/// What the camera sees.
#[derive(Debug, Clone)]
pub struct View {
    /// The video frame.
    pub frame: VideoFrame,
    /// The box around what is seen of the target; `None` where nothing is.
    pub target: Option<PixelBox>,
}

/// Who is told what happens in a trial: a recorder.
pub trait Witness {
    /// The pilot took a step.
    fn step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates);
    /// A picture was taken, of this.
    fn truth(&mut self, truth: &Truth);
    /// The same moment, for those who draw it.
    fn world(&mut self, _world: &World) {}
}

/// Takes no notice.
impl Witness for () {
    fn step(&mut self, _now: Timestamp, _input: &Input<'_>, _outcome: &Outcome, _rates: VehicleRates) {}
    fn truth(&mut self, _truth: &Truth) {}
}

/// A trial that is being simulated.
pub struct Simulation<'a> {
    world: World,
    sensor: LocalisationSensor,
    pilot: Pilot,
    profile: &'a VehicleProfile,
    video: VideoLink,
    on_the_way: VecDeque<(u64, Sight, Truth)>,
    last_shown: Option<Sight>,
    lost_since: Option<Timestamp>,
    selected: bool,
    outcome: Option<Outcome>,
    rates: VehicleRates,
    reports_tilt: bool,
    log: TrialLog,
}

/// What comes from the camera to the pilot.
#[derive(Clone)]
enum Sight {
    Localisation(Option<Localisation>),
    View(Box<View>),
}

impl Sight {
    /// This one, showing what another one showed.
    fn frozen(self, shown: &Self) -> Self {
        match (self, shown) {
            (Self::Localisation(now), Self::Localisation(then)) => Self::Localisation(then.map(|then| {
                let captured = now.map_or(then.captured, |now| now.captured);
                Localisation { captured, ..then }
            })),
            (Self::View(mut now), Self::View(then)) => {
                now.frame.picture = then.frame.picture.clone();
                now.target = then.target;
                Self::View(now)
            }
            (now, _) => now,
        }
    }
}

impl<'a> Simulation<'a> {
    /// A trial of a scenario whose plant was drawn, if it was to be. The pilot must be fresh.
    pub fn new(
        scenario: &Scenario,
        world: World,
        seed: u64,
        pilot: Pilot,
        profile: &'a VehicleProfile,
    ) -> Self {
        let camera = &scenario.camera;
        let log = TrialLog {
            rows: Vec::new(),
            last_row_s: 1.0 / f64::from(camera.pictures_per_second),
            frame: camera.frame,
            picture: camera.optics.picture,
            knows_lost: true,
            truth: Some(Vec::new()),
        };
        Self {
            sensor: LocalisationSensor::new(scenario.sensing, camera.clone(), seed),
            world,
            pilot,
            profile,
            video: VideoLink::new(camera.video, seed),
            on_the_way: VecDeque::new(),
            last_shown: None,
            lost_since: None,
            selected: false,
            outcome: None,
            rates: VehicleRates::REST,
            reports_tilt: false,
            log,
        }
    }

    /// The same with a gimbal that reports the camera's tilt, ten times a second.
    #[must_use]
    pub fn reporting_tilt(self, reports_tilt: bool) -> Self {
        Self { reports_tilt, ..self }
    }

    /// Runs to the end: with an eye in pixels, without one by the sensor.
    pub fn run(mut self, mut eye: Option<&mut dyn Eye>, witness: &mut dyn Witness) -> TrialLog {
        self.request(OperatorRequest::Engage, witness);
        while !self.is_over() {
            self.tick(&mut eye, witness);
        }
        self.log
    }

    /// How the target moved in the picture so far, and what was done about it.
    pub fn into_log(self) -> TrialLog {
        self.log
    }

    /// Puts a request to the pilot, now.
    pub fn request(&mut self, request: OperatorRequest, witness: &mut dyn Witness) {
        self.step(Input::Request(request), witness);
    }

    /// From now on somebody else steers the boat, or nobody but the scenario's helmsman again.
    pub fn steer(&mut self, helm: Option<HelmCommand>) {
        self.world.override_helm(helm);
    }

    /// The world as it is now.
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// Whether the trial is over.
    pub fn is_over(&self) -> bool {
        self.world.is_over()
    }

    /// One tick: a picture is taken, one arrives, the pilot is stepped, the world moves on.
    pub fn tick(&mut self, eye: &mut Option<&mut dyn Eye>, witness: &mut dyn Witness) {
        if self.world.is_frame_due() {
            let truth = self.world.truth();
            witness.truth(&truth);
            witness.world(&self.world);
            let sight = match eye {
                Some(eye) => Sight::View(Box::new(eye.look(&self.world))),
                None => Sight::Localisation(self.sensor.measure(&truth)),
            };
            match (self.video.send(self.world.tick()), self.last_shown.take()) {
                (Delivery::Arrives { at }, _) => {
                    self.last_shown = Some(sight.clone());
                    self.on_the_way.push_back((at, sight, truth));
                }
                (Delivery::Frozen { at }, Some(shown)) => {
                    self.on_the_way.push_back((at, sight.frozen(&shown), truth));
                    self.last_shown = Some(shown);
                }
                (Delivery::Frozen { .. } | Delivery::Lost, shown) => self.last_shown = shown,
            }
        }
        while let Some((_, sight, truth)) = self.on_the_way.pop_front_if(|(at, ..)| *at <= self.world.tick())
        {
            self.arrive(&sight, &truth, eye, witness);
        }
        let now = self.world.now();
        if self.reports_tilt && self.world.tick().is_multiple_of(u64::from(TICKS_PER_TILT_REPORT)) {
            let report = Report::CameraTilt(self.world.camera_pose().tilt);
            self.step(Input::Telemetry(Telemetry { at: now, report }), witness);
        }
        if self.outcome.as_ref().and_then(|outcome| outcome.wake_at).is_some_and(|at| at <= now) {
            let before = self.rates;
            self.step(Input::Tick, witness);
            if self.rates != before
                && let Some(row) = self.log.truth.as_ref().and_then(|rows| rows.last().copied())
            {
                self.note(row);
            }
        }
        self.world.advance();
    }

    fn arrive(
        &mut self,
        sight: &Sight,
        truth: &Truth,
        eye: &mut Option<&mut dyn Eye>,
        witness: &mut dyn Witness,
    ) {
        match sight {
            Sight::Localisation(seen) => {
                let track = self.track_of(*seen, truth.at);
                self.step(Input::Localisation(track), witness);
            }
            Sight::View(view) => {
                if !self.selected
                    && let Some(selection) = view.target
                {
                    self.selected = true;
                    self.step(Input::Request(OperatorRequest::Select(selection)), witness);
                }
                let frame = eye.as_mut().map_or_else(|| view.frame.clone(), |eye| eye.receive(view));
                self.step(Input::Frame(&frame), witness);
            }
        }
        let (target, camera) = (truth.target.position, truth.camera.position);
        self.note(RowTruth {
            out_of_picture: !truth.in_picture,
            achieved: None,
            target_m: (target.x, target.y),
            camera_m: (camera.x, camera.y),
        });
    }

    /// A track that was measured elsewhere: lost from when nothing was measured any more.
    fn track_of(&mut self, seen: Option<Localisation>, at: Timestamp) -> Track {
        match seen {
            Some(seen) => {
                (self.lost_since, self.selected) = (None, true);
                Track::Tracking(seen)
            }
            None if self.selected => {
                Track::Lost { since: *self.lost_since.get_or_insert(at), confidence: 0.0 }
            }
            None => Track::Unseeded,
        }
    }

    fn step(&mut self, input: Input<'_>, witness: &mut dyn Witness) {
        let now = self.world.now();
        let outcome = self.pilot.step(input, now);
        let rates = self.profile.outgoing(outcome.command);
        self.world.command(self.profile.incoming(rates));
        witness.step(now, &input, &outcome, rates);
        self.rates = rates;
        self.outcome = Some(outcome);
    }

    /// A row of the log, from the first localisation on, with what was true of the picture that it rests on.
    fn note(&mut self, row: RowTruth) {
        let Some(outcome) = &self.outcome else { return };
        if self.log.rows.is_empty() && outcome.percept.is_none() {
            return;
        }
        self.log.rows.push(LogRow {
            time_s: outcome.at.as_secs_f64(),
            position: outcome.percept.map(|percept| percept.position),
            rates: Some(self.rates),
        });
        if let Some(truth) = &mut self.log.truth {
            truth.push(RowTruth { achieved: Some(self.world.camera_rates()), ..row });
        }
    }
}
