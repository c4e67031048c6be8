//! One run of the campaign: thirteen seconds of the world, millisecond by millisecond.

use anyhow::Result;
use barrelman_control::OptimalSettings;
use barrelman_pilot::LawSettings;
use barrelman_vocab::OptimalMode;
use barrelman_vocab::{CameraRequest, Nudge, OperatorRequest, StopCause, TestMotions, Timestamp};

use super::fault::{self, FaultKind};
use super::machine::{Machine, Moment};
use super::mutant::Mutant;
use super::oracle::{Licence, Oracle};
use super::picture::{FRAME_MS, SeenPicture, boat_bearing_rad};
use super::program::Program;
use super::run_result::RunResult;
use super::station::Station;
use super::video_path::VideoPath;
use crate::rng_of_name::rng_of_name;
use crate::vehicle::Vehicle;

/// How long a run lasts, ms.
pub(super) const LASTS_MS: u64 = 13_000;
const ENGAGES_AT_MS: u64 = 1_500;
/// The boat is out of sight from here on in the runs with a search, ms.
const LOST_FROM_MS: u64 = 600;
const SEARCHES_AT_MS: u64 = 3_900;
const CALIBRATES_AT_MS: u64 = 3_000;
const NUDGE_INTERVAL_MS: u64 = 100;
/// A gimbal of another commander is left alone after this time on a line without faults, ms: a manager that
/// tells a change once, on a line that loses what it tells, is asked again each second.
const YIELDS_WITHIN_MS: u64 = 1_500;
/// A turn that nobody commands is told within this time, ms: the laboratory's camera turns on for half a
/// second at full rate, then half a second of reports has to show that it does not get slower.
const TOLD_WITHIN_MS: u64 = 1_300;
/// A camera that turns no faster may sway, rad/s.
const SWAY_RAD_PER_S: f64 = 0.15;
/// From the loss of commands to the Stop that is lost, ms.
const LOST_STOP_MS: u64 = 50;
/// An alarm about motion ends within this time of the end of the motion, ms.
const UNTOLD_WITHIN_MS: u64 = 1_000;
/// A slower turn may be one that is running out, or sway, rad/s.
const FAST_RAD_PER_S: f64 = 0.25;
/// An operator engages again this long after a fault, in half of the runs, ms.
const ENGAGES_AGAIN_MS: u64 = 1_000;

struct World {
    machine: Machine,
    mutant: Mutant,
    licence: Licence,
    phase: f64,
    engages_again: bool,
    station: Box<dyn Station>,
    /// Since when another commander has commanded the camera, on a line without faults.
    elsewhere_since_ms: Option<u64>,
    /// Since when the camera has turned fast although zero is commanded, and the vehicle says so.
    unasked_since_ms: Option<u64>,
    /// Since when the camera has been at rest, and the vehicle says so.
    resting_since_ms: Option<u64>,
    program: Program,
    video: VideoPath,
    oracle: Oracle,
    has_zoom: bool,
}

/// Runs the run with this number. `trace` takes what the ground station receives.
///
/// # Errors
/// If the tracker of the pilot, which is not used, cannot be built.
pub(super) fn run(
    vehicle: Vehicle,
    number: u64,
    seed: u64,
    mutant: Mutant,
    trace: &mut dyn FnMut(&str),
) -> Result<RunResult> {
    let mut rng = rng_of_name("faults", seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let faults = fault::draw(number, &vehicle.faults(), &mut rng);
    let is_worst = rng.uniform() < 0.5;
    let licence = match rng.uniform() {
        ..0.55 => Licence::Follow,
        ..0.7 => Licence::Nudge,
        ..0.85 => Licence::Search,
        _ => Licence::Calibrate,
    };
    let law = if rng.uniform() < 0.5 {
        LawSettings::MotorSchema
    } else {
        LawSettings::Optimal(OptimalSettings::new(OptimalMode::MinimumEnergy))
    };
    let mut world = World {
        mutant,
        licence,
        phase: rng.between(0.0, core::f64::consts::TAU),
        engages_again: rng.uniform() < 0.5,
        station: vehicle.station(&faults, is_worst, mutant),
        program: Program::new(vehicle.subject(), law)?,
        has_zoom: vehicle.subject().zoom.is_some(),
        elsewhere_since_ms: None,
        unasked_since_ms: None,
        resting_since_ms: None,
        machine: Machine::start(vehicle.link_plan(mutant)?, faults, rng_of_name("line", number ^ seed)),
        video: VideoPath::new(mutant),
        oracle: Oracle::new(vehicle.rest_limit_ms()),
    };
    for at_ms in 0..LASTS_MS {
        world.advance(at_ms, trace);
    }
    Ok(RunResult {
        worst_ms: vec![world.oracle.worst_ms()],
        moved: world.oracle.moved().iter().map(|licence| licence.name()).collect(),
        violation: world.oracle.violation().cloned(),
        is_excluded: world.machine.is_excluded(),
        faults: world.machine.faults,
    })
}

impl World {
    fn advance(&mut self, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        self.machine.line.advance(at_ms);
        self.station.advance(&mut self.machine.line, at_ms, trace);
        self.capture(at_ms);
        if let Some(moment) = self.machine.begin(at_ms) {
            let is_struck = self.machine.advance_link(&mut self.program.end, moment);
            if moment.was_suspended || is_struck {
                self.oracle.excuse(at_ms);
            }
            self.oracle.set_live_guard(self.machine.has_live_guard());
            self.advance_program(moment);
        }
        self.judge(at_ms);
        self.judge_unasked_motion(at_ms);
        self.judge_false_alarm(at_ms);
    }

    /// Nothing is told of a camera that rests.
    fn judge_false_alarm(&mut self, at_ms: u64) {
        let is_resting = self.station.rates().is_rest()
            && self.machine.line.is_heard(at_ms)
            && self.machine.runs(at_ms)
            && self.program.sees_camera(self.machine.now(at_ms));
        if !is_resting {
            self.resting_since_ms = None;
            return;
        }
        let since_ms = *self.resting_since_ms.get_or_insert(at_ms);
        if self.program.is_motion_told && at_ms - since_ms > UNTOLD_WITHIN_MS {
            self.oracle.tells_of_no_motion(at_ms, at_ms - since_ms);
        }
    }

    /// The rate in force of the faster axis.
    fn fastest_rad_per_s(&self) -> f64 {
        let rates = self.station.rates();
        let [yaw, pitch] = [rates.yaw, rates.pitch].map(|rate| rate.radians_per_second().abs());
        yaw.max(pitch)
    }

    /// A stop that does not arrive, while the vehicle's reports do, is told.
    fn judge_unasked_motion(&mut self, at_ms: u64) {
        let is_unasked = self.fastest_rad_per_s() >= FAST_RAD_PER_S
            && self.program.is_rest_commanded
            && self.program.sees_camera(self.machine.now(at_ms))
            && self.machine.line.is_heard(at_ms)
            && self.machine.has_link()
            && self.machine.runs(at_ms)
            && !self.station.is_anothers();
        let is_told = self.program.is_motion_told && self.mutant != Mutant::NoMotionWatch;
        if !is_unasked || is_told {
            self.unasked_since_ms = None;
            return;
        }
        let since_ms = *self.unasked_since_ms.get_or_insert(at_ms);
        if at_ms - since_ms > TOLD_WITHIN_MS {
            self.oracle.is_silent_about_motion(at_ms, at_ms - since_ms);
        }
    }

    /// The pictures of the camera: the boat swings to and fro before it.
    fn capture(&mut self, at_ms: u64) {
        if self.machine.begins(FaultKind::MediaProgramGone, at_ms) {
            self.video.lose_connection();
        }
        let comes_no_picture = [FaultKind::VideoStalls, FaultKind::MediaProgramGone]
            .iter()
            .any(|kind| self.machine.is_active(*kind, at_ms));
        if !at_ms.is_multiple_of(FRAME_MS) || comes_no_picture {
            return;
        }
        let boat_rad = boat_bearing_rad(self.phase, at_ms);
        let is_out_of_sight = self.licence == Licence::Search && at_ms >= LOST_FROM_MS;
        let is_found = !is_out_of_sight && !self.machine.is_active(FaultKind::TrackLost, at_ms);
        let picture = SeenPicture {
            bearing_rad: is_found.then_some(boat_rad - self.station.pan_rad()),
            is_coasting: self.machine.is_active(FaultKind::TrackCoasts, at_ms),
        };
        self.video.send(picture, &self.machine.faults, at_ms);
    }

    fn advance_program(&mut self, moment: Moment) {
        let Moment { now, at_ms, was_suspended } = moment;
        if !self.machine.advance_program(&mut self.program.end, moment) {
            return;
        }
        let turn = self.machine.turn(moment);
        if turn.was_away {
            self.oracle.withdraw();
        }
        if was_suspended {
            self.video.clear();
        }
        if was_suspended || turn.is_noticed {
            self.program.on_suspension(&mut self.oracle, now);
        }
        self.ask(now, at_ms);
        self.program.advance(&mut self.oracle, now);
        if let Some(arrived) = self.video.receive(at_ms, now) {
            self.program.see(arrived, &mut self.oracle, now, at_ms);
        }
    }

    /// What the operator asks for.
    fn ask(&mut self, now: Timestamp, at_ms: u64) {
        if self.machine.begins(FaultKind::ProgramEnds, at_ms) && !self.machine.is_closing {
            self.machine.is_closing = true;
            self.oracle.withdraw();
            self.program.close(now);
        }
        if self.machine.is_closing {
            return;
        }
        let is_lost_stop = self.machine.begins(FaultKind::CommandsLost, at_ms.saturating_sub(LOST_STOP_MS));
        if is_lost_stop {
            self.oracle.withdraw();
            self.program.request(OperatorRequest::Stop(StopCause::Operator), now);
        }
        if self.machine.begins(FaultKind::OperatorStops, at_ms) {
            self.oracle.withdraw();
            self.program.request(OperatorRequest::Stop(StopCause::Operator), now);
            if self.mutant == Mutant::NoLatch {
                // A stop that does not last: the pilot goes on as if it had not been stopped.
                self.program.request(OperatorRequest::Camera(CameraRequest::Engage), now);
            }
        }
        let ends_ms = fault::last_end_ms(&self.machine.faults);
        match self.licence {
            Licence::Follow => {
                let again = self.engages_again && at_ms == ends_ms + ENGAGES_AGAIN_MS;
                if at_ms == ENGAGES_AT_MS || again {
                    self.oracle.consent(Licence::Follow);
                    self.program.request(OperatorRequest::Camera(CameraRequest::Engage), now);
                }
            }
            Licence::Search | Licence::Calibrate => self.ask_for_behaviour(ends_ms, now, at_ms),
            Licence::Nudge => {
                let is_held =
                    at_ms >= ENGAGES_AT_MS && !self.machine.is_active(FaultKind::OperatorStops, at_ms);
                if is_held && at_ms.is_multiple_of(NUDGE_INTERVAL_MS) {
                    self.oracle.consent(Licence::Nudge);
                    self.oracle.nudged(at_ms);
                    let pan = if at_ms % 4_000 < 2_000 { 1.0 } else { -1.0 };
                    let zoom = if self.has_zoom { -pan } else { 0.0 };
                    self.program.request(
                        OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan, tilt: 0.5, zoom })),
                        now,
                    );
                }
            }
        }
    }

    /// Asks for a search of the boat that was followed, or for a calibration; in half of the runs once more
    /// after the faults.
    fn ask_for_behaviour(&mut self, ends_ms: u64, now: Timestamp, at_ms: u64) {
        let is_search = self.licence == Licence::Search;
        let (first_ms, request) = if is_search {
            (SEARCHES_AT_MS, OperatorRequest::Camera(CameraRequest::Search))
        } else {
            (
                CALIBRATES_AT_MS,
                OperatorRequest::Camera(CameraRequest::Calibrate { motions: TestMotions::Axes }),
            )
        };
        let again_ms = ends_ms + ENGAGES_AGAIN_MS;
        let is_again = self.engages_again && at_ms == again_ms;
        if is_search && at_ms == ENGAGES_AT_MS {
            self.program.request(OperatorRequest::Camera(CameraRequest::Engage), now);
        }
        if is_again {
            // A stop may have to be ended first.
            self.oracle.withdraw();
            self.program.request(OperatorRequest::Camera(CameraRequest::Disengage), now);
        }
        if at_ms == first_ms || is_again {
            self.oracle.consent_to_behaviour(self.licence, at_ms);
            self.program.request(request, now);
        }
    }

    fn judge(&mut self, at_ms: u64) {
        if self.machine.line.is_disturbed(at_ms) {
            self.oracle.excuse(at_ms + 1);
        }
        let is_unknown =
            self.machine.line.is_disturbed(at_ms) || self.machine.is_active(FaultKind::StatusWithheld, at_ms);
        if !self.station.is_anothers() || is_unknown || self.machine.is_suspended() {
            self.elsewhere_since_ms = None;
        } else {
            let since_ms = *self.elsewhere_since_ms.get_or_insert(at_ms);
            if self.station.is_meddled_with() && at_ms - since_ms > YIELDS_WITHIN_MS {
                self.oracle.meddles(at_ms, at_ms - since_ms);
            }
        }
        if self.machine.is_suspended() || self.machine.line.is_disturbed(at_ms) || self.machine.is_excluded()
        {
            return;
        }
        // The motion is that of another commander.
        if self.station.is_anothers() {
            self.oracle.excuse(at_ms);
            return;
        }
        // A shut-down cannot tell a slow turn from rest or sway, and ends though its zeros got lost.
        if self.machine.has_ended_deaf(at_ms) && self.fastest_rad_per_s() <= SWAY_RAD_PER_S {
            return;
        }
        self.oracle.judge(at_ms, !self.station.rates().is_rest());
    }
}
