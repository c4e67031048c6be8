//! One simulated trial, in lock step.
//!
//! ```text
//!   World --truth--> Sensor or FrameSource --video link--> Pilot::step --command--> vehicle profile --> World
//! ```
//! Time advances in ticks of the world. A picture captured in one tick reaches the pilot some ticks later, or
//! never, as the simulated video link decides. A command reaches the camera in the tick in which the pilot
//! gave it. Between two pictures the pilot is stepped at the time that its last outcome asked for.

use std::collections::VecDeque;

use barrelman_pilot::{Input, Notice, Outcome, Pilot, VesselMode};
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::camera_mount::TICKS_PER_TILT_REPORT;
use barrelman_sim::video_link::{Delivery, VideoLink};
use barrelman_sim::world::{Truth, World};
use barrelman_sim::{LocalisationSensor, Optics, Scenario};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{
    Angle, CameraRequest, LawId, Localisation, OperatorRequest, Telemetry, Timestamp, Track, VehicleProfile,
    VehicleRates,
};

use super::camera_output::CameraOutput;
use super::frame_source::FrameSource;
use super::rescue::Rescue;
use super::simulated_operator::SimulatedOperator;
use super::step_observer::StepObserver;
use crate::logs::{LogRow, RowTruth, TrialLog};
use crate::target_in_picture::JudgedTrack;

/// A simulated trial in progress.
pub struct Simulation<'a> {
    world: World,
    sensor: LocalisationSensor,
    pilot: Pilot,
    profile: &'a VehicleProfile,
    video: VideoLink,
    /// Camera outputs in transit, each with its tick of arrival.
    in_flight: VecDeque<(u64, CameraOutput, Truth)>,
    /// The last output that was not frozen: a frozen picture repeats its content.
    last_live: Option<CameraOutput>,
    lost_since: Option<Timestamp>,
    is_selected: bool,
    operator: SimulatedOperator,
    outcome: Option<Outcome>,
    rates: VehicleRates,
    reports_tilt: bool,
    reports_height: bool,
    report_errors: ReportErrors,
    rescue: Option<Rescue>,
    /// Commands of the helm that are still to come, each with its tick.
    helm: VecDeque<(u64, Option<HelmCommand>)>,
    log: TrialLog,
    /// Whether rows are added to the log.
    keeps_log: bool,
}

/// By how much the vehicle's reports are off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReportErrors {
    /// Reported over true height.
    pub height_factor: f64,
    /// Reported less true tilt.
    pub tilt: Angle,
    /// Whether a camera that zooms reports its field of view.
    pub has_field_of_view: bool,
}

impl ReportErrors {
    /// Exact reports.
    pub const NONE: Self = Self { height_factor: 1.0, tilt: Angle::ZERO, has_field_of_view: true };
}

impl<'a> Simulation<'a> {
    /// Prepares a trial in `world`, which must belong to the scenario and the seed. The pilot must not have
    /// been stepped yet.
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
            last_row_duration_s: 1.0 / f64::from(camera.pictures_per_second),
            frame: camera.frame,
            picture: camera.optics.picture,
            records_track_loss: true,
            truth: Some(Vec::new()),
            selections: None,
            guidance: None,
            water: None,
        };
        Self {
            sensor: LocalisationSensor::new(scenario.sensing, camera.clone(), seed),
            world,
            pilot,
            profile,
            video: VideoLink::new(camera.video, seed),
            in_flight: VecDeque::new(),
            last_live: None,
            lost_since: None,
            is_selected: false,
            operator: SimulatedOperator::Exact,
            outcome: None,
            rates: VehicleRates::REST,
            reports_tilt: false,
            reports_height: false,
            report_errors: ReportErrors::NONE,
            rescue: None,
            helm: VecDeque::new(),
            log,
            keeps_log: true,
        }
    }

    /// Sets whether the gimbal reports the camera's tilt, at 10 Hz. Off by default.
    #[must_use]
    pub fn with_tilt_reports(self, reports_tilt: bool) -> Self {
        Self { reports_tilt, ..self }
    }

    /// The same trial, in which the vehicle reports the camera's height above the water, at 10 Hz.
    #[must_use]
    pub fn with_height_reports(self) -> Self {
        Self { reports_height: true, ..self }
    }

    /// The same trial, in which the reports of height and tilt are off.
    #[must_use]
    pub fn with_report_errors(self, report_errors: ReportErrors) -> Self {
        Self { report_errors, ..self }
    }

    /// The same trial, in which an operator marks the people that the scenario has, and lets the boat go to
    /// the first one. Needs a pilot with a vessel.
    #[must_use]
    pub fn with_rescue(self, optics: Optics, seed: u64) -> Self {
        Self { rescue: Some(Rescue::new(optics, seed)), ..self }
    }

    /// The same trial, in which the target is selected as a person would do it: once, when the target is well
    /// visible, by a box drawn by hand.
    #[must_use]
    pub fn with_selection_by_hand(self, seed: u64) -> Self {
        Self { operator: SimulatedOperator::person(seed), ..self }
    }

    /// Sets whether a log is kept. Without one, the memory does not grow with the trial's length, and
    /// [`Self::into_log`] is empty. On by default.
    #[must_use]
    pub fn with_log(self, keeps_log: bool) -> Self {
        Self { keeps_log, ..self }
    }

    /// The same trial, in which the boat is steered as it was in another one: by each command of the helm
    /// from its tick on, and by the helmsman where there is none. The pilot must have no vessel.
    #[must_use]
    pub fn with_helm(self, helm: Vec<(u64, Option<HelmCommand>)>) -> Self {
        Self { helm: helm.into(), ..self }
    }

    /// The same trial in which a person selects the target: the world does not select it.
    #[must_use]
    pub fn without_selection(self) -> Self {
        Self { is_selected: true, ..self }
    }

    /// Runs the trial to its end: in pixels with a frame source, on the sensor's localisations without one.
    pub fn run(
        mut self,
        mut frames: Option<&mut dyn FrameSource>,
        observer: &mut dyn StepObserver,
    ) -> TrialLog {
        self.request(OperatorRequest::Camera(CameraRequest::Engage), observer);
        while !self.is_over() {
            self.tick(&mut frames, observer);
        }
        self.into_log()
    }

    /// The log of the trial so far, without the figures of the guidance.
    pub const fn log(&self) -> &TrialLog {
        &self.log
    }

    /// The log of the trial.
    pub fn into_log(mut self) -> TrialLog {
        self.log.guidance = self.rescue.as_ref().map(Rescue::metrics);
        self.log
    }

    /// Passes an operator's request to the pilot, at the present time.
    pub fn request(&mut self, request: OperatorRequest, observer: &mut dyn StepObserver) {
        self.step_pilot(Input::Request(request), observer);
    }

    /// The law; `None`: a law that an operator cannot choose.
    pub const fn law_id(&self) -> LawId {
        self.pilot.law_id()
    }

    /// Whether a further stop would change nothing ([`Pilot::is_at_rest_by_stop`]).
    pub fn is_at_rest_by_stop(&self) -> bool {
        self.pilot.is_at_rest_by_stop()
    }

    /// The outcome of the pilot's newest step.
    pub const fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// The world in its present state.
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// Whether the trial is over.
    pub fn is_over(&self) -> bool {
        self.world.is_over() || self.rescue.as_ref().is_some_and(Rescue::is_over)
    }

    /// Simulates one tick: captures a picture where one is due, delivers those that arrive, steps the pilot
    /// where it is due, and advances the world.
    pub fn tick(&mut self, frames: &mut Option<&mut dyn FrameSource>, observer: &mut dyn StepObserver) {
        if self.world.is_frame_due() {
            let truth = self.world.truth();
            let output = match frames {
                Some(frames) => CameraOutput::Frame(Box::new(frames.capture(&self.world))),
                None => CameraOutput::Localisation(self.sensor.measure(&truth)),
            };
            observer.on_truth(&truth, output.target());
            observer.on_world(&self.world);
            match (self.video.send(self.world.tick()), self.last_live.take()) {
                (Delivery::Arrives { at }, _) => {
                    self.last_live = Some(output.clone());
                    self.in_flight.push_back((at, output, truth));
                }
                (Delivery::Frozen { at }, Some(live)) => {
                    self.in_flight.push_back((at, output.with_content_of(&live), truth));
                    self.last_live = Some(live);
                }
                (Delivery::Frozen { .. } | Delivery::Lost, live) => self.last_live = live,
            }
        }
        while let Some((_, output, truth)) = self.in_flight.pop_front_if(|(at, ..)| *at <= self.world.tick())
        {
            self.deliver(&output, &truth, frames, observer);
        }
        let now = self.world.now();
        if self.world.tick().is_multiple_of(u64::from(TICKS_PER_TILT_REPORT)) {
            let pose = self.world.camera_pose();
            let tilt = Angle::from_radians(pose.tilt.radians() + self.report_errors.tilt.radians());
            let tilt = self.reports_tilt.then_some(Report::CameraTilt(tilt));
            let height_m = self.report_errors.height_factor * pose.position.z;
            let height = self.reports_height.then_some(Report::CameraHeight(height_m));
            let field_of_view = self.world.zoomed_field_of_view().map(Report::FieldOfView);
            let field_of_view = field_of_view.filter(|_| self.report_errors.has_field_of_view);
            for report in [tilt, height, field_of_view].into_iter().flatten() {
                self.step_pilot(Input::Telemetry(Telemetry { at: now, report }), observer);
            }
        }
        if self.outcome.as_ref().and_then(Outcome::next_step_at).is_some_and(|at| at <= now) {
            let rates_before = self.rates;
            self.step_pilot(Input::Tick, observer);
            if self.rates != rates_before
                && let Some(row) = self.log.truth.as_ref().and_then(|rows| rows.last().copied())
            {
                self.push_row(row);
            }
        }
        while let Some((_, helm)) = self.helm.pop_front_if(|(tick, _)| *tick <= self.world.tick()) {
            self.world.override_helm(helm);
        }
        self.world.advance();
        if let (Some(rescue), Some(outcome)) = (&mut self.rescue, &self.outcome) {
            rescue.on_tick(&self.world, outcome.vessel.mode, outcome.vessel.command);
        }
    }

    fn deliver(
        &mut self,
        output: &CameraOutput,
        truth: &Truth,
        frames: &mut Option<&mut dyn FrameSource>,
        observer: &mut dyn StepObserver,
    ) {
        match output {
            CameraOutput::Localisation(localisation) => {
                let track = self.track_from(*localisation, truth.at);
                self.step_pilot(Input::Localisation(track), observer);
            }
            CameraOutput::Frame(captured) => {
                self.log.selections.get_or_insert(0);
                let selection = (!self.is_selected)
                    .then(|| self.operator.selection(&captured.target, captured.frame.picture.size()))
                    .flatten();
                if let Some(selection) = selection {
                    self.is_selected = true;
                    self.step_pilot(
                        Input::Request(OperatorRequest::Camera(CameraRequest::SelectNext(selection))),
                        observer,
                    );
                }
                let frame =
                    frames.as_mut().map_or_else(|| captured.frame.clone(), |frames| frames.deliver(captured));
                self.step_pilot(Input::Frame(&frame), observer);
                let notice = self.outcome.as_ref().and_then(|outcome| outcome.notice.as_ref());
                let is_refused = matches!(notice, Some(Notice::SelectionRefused(_)));
                if selection.is_some() && is_refused && self.operator == SimulatedOperator::Exact {
                    (self.operator, self.is_selected) = (SimulatedOperator::ExactAgain, false);
                }
            }
        }
        if let (Some(rescue), Some(outcome)) = (&mut self.rescue, &self.outcome) {
            for request in rescue.requests(truth, &self.world, outcome, self.world.now()) {
                self.step_pilot(Input::Request(request), observer);
            }
        }
        let (target, camera) = (truth.target.position, truth.camera.position);
        let track = self.outcome.as_ref().map(|outcome| outcome.track);
        let judged = track.zip(output.target());
        self.push_row(RowTruth {
            out_of_picture: !truth.in_picture,
            achieved_rates: None,
            track: judged.map(|(track, target)| JudgedTrack::new(track, target, truth.image)),
            target_m: (target.x, target.y),
            camera_m: (camera.x, camera.y),
        });
    }

    /// The track that follows from the sensor's localisation of a picture captured at `at`: lost since the
    /// first picture without one.
    fn track_from(&mut self, localisation: Option<Localisation>, at: Timestamp) -> Track {
        match localisation {
            Some(localisation) => {
                (self.lost_since, self.is_selected) = (None, true);
                Track::Tracking(localisation)
            }
            None if self.is_selected => {
                Track::Lost { since: *self.lost_since.get_or_insert(at), confidence: 0.0 }
            }
            None => Track::Unseeded,
        }
    }

    fn step_pilot(&mut self, input: Input<'_>, observer: &mut dyn StepObserver) {
        if matches!(input, Input::Request(OperatorRequest::Camera(request)) if request.is_selection()) {
            self.log.selections = self.log.selections.map(|selections| selections + 1);
        }
        let now = self.world.now();
        let outcome = self.pilot.step(input, now);
        let rates = self.profile.to_vehicle(outcome.command);
        self.world.command(self.profile.from_vehicle(rates));
        if outcome.vessel.mode != VesselMode::Absent {
            let is_commanded = outcome.vessel.is_commanded();
            self.world.override_helm(is_commanded.then(|| HelmCommand::of(outcome.vessel.command)));
        }
        observer.on_step(now, &input, &outcome, rates);
        self.rates = rates;
        self.outcome = Some(outcome);
    }

    /// Adds a row to the log: in pixels from the first picture on, otherwise from the first localisation on.
    /// `truth` belongs to the picture that the row rests on.
    fn push_row(&mut self, truth: RowTruth) {
        let Some(outcome) = self.outcome.as_ref().filter(|_| self.keeps_log) else { return };
        let localised = outcome.percept.map(|percept| percept.position);
        let position = truth.track.map(|track| track.position).or(localised);
        if self.log.rows.is_empty() && position.is_none() {
            return;
        }
        let command = Some(self.profile.from_vehicle(self.rates));
        self.log.rows.push(LogRow { time_s: outcome.at.as_secs_f64(), position, command });
        if let Some(rows) = &mut self.log.truth {
            rows.push(RowTruth { achieved_rates: Some(self.world.camera_rates()), ..truth });
        }
    }
}
