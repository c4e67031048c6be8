//! One run of the campaign: thirteen seconds of the world, millisecond by millisecond.

use std::collections::VecDeque;

use anyhow::Result;
use barrelman_control::{OptimalMode, OptimalSettings};
use barrelman_link::LinkReport;
use barrelman_pilot::LawSettings;
use barrelman_vocab::{Nudge, OperatorRequest, StopCause, Timestamp};

use super::fault::{self, Fault, FaultKind};
use super::line::Line;
use super::link_host::LinkHost;
use super::mutant::Mutant;
use super::oracle::{Licence, Oracle};
use super::program::{Program, SeenPicture};
use super::station::Station;
use crate::rng::Rng;
use crate::vehicle::Vehicle;

const LASTS_MS: u64 = 13_000;
const FRAME_MS: u64 = 33;
/// From the capture of a picture to its arrival, ms.
const VIDEO_LATENCY_MS: u64 = 120;
/// Added to it while the video is late, ms.
const VIDEO_LATE_MS: u64 = 700;
const ENGAGES_AT_MS: u64 = 1_500;
/// The boat is out of sight from here on in the runs with a search, ms.
const LOST_FROM_MS: u64 = 600;
const SEARCHES_AT_MS: u64 = 3_900;
const CALIBRATES_AT_MS: u64 = 3_000;
const NUDGE_INTERVAL_MS: u64 = 100;
/// From the death of a guard to the start of the next, ms.
const GUARD_STARTS_MS: u64 = 40;
/// A program that is gone within this time of its guard's death cannot replace it, ms: both are killed together.
const TOGETHER_MS: u64 = 400;
/// A gimbal of another commander is left alone after this time on a line without faults, ms: a manager that tells a change once,
/// on a line that loses what it tells, is asked again each second.
const YIELDS_WITHIN_MS: u64 = 1_500;
/// An operator engages again this long after a fault, in half of the runs, ms.
const ENGAGES_AGAIN_MS: u64 = 1_000;

/// What a run came to.
#[derive(Debug)]
pub(super) struct RunResult {
    pub(super) faults: Vec<Fault>,
    pub(super) worst_ms: u64,
    pub(super) moved: Vec<Licence>,
    pub(super) violation: Option<(u64, String)>,
    /// Whether guard and program were gone together, for which there is no help.
    pub(super) is_excluded: bool,
}

struct World {
    vehicle: Vehicle,
    faults: Vec<Fault>,
    mutant: Mutant,
    licence: Licence,
    phase: f64,
    engages_again: bool,
    line: Line,
    station: Box<dyn Station>,
    /// Since when another commander has commanded the camera, on a line without faults.
    elsewhere_since_ms: Option<u64>,
    program: Program,
    link: Option<LinkHost>,
    guard_starts_at_ms: Option<u64>,
    /// Whether the guard before has sent zeros and stop.
    is_stop_sent: bool,
    guard_died_at_ms: Option<u64>,
    program_gone_at_ms: Option<u64>,
    is_closing: bool,
    is_suspended: bool,
    suspended_ms: u64,
    pictures: VecDeque<(u64, SeenPicture)>,
    oracle: Oracle,
    is_excluded: bool,
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
    let mut rng = Rng::from_name("faults", seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let faults = fault::draw(number, &vehicle.faults(), &mut rng);
    let is_worst = rng.uniform(0.0, 1.0) < 0.5;
    let licence = match rng.uniform(0.0, 1.0) {
        ..0.55 => Licence::Follow,
        ..0.7 => Licence::Nudge,
        ..0.85 => Licence::Search,
        _ => Licence::Calibrate,
    };
    let law = if rng.uniform(0.0, 1.0) < 0.5 {
        LawSettings::MotorSchema
    } else {
        LawSettings::Optimal(OptimalSettings::new(OptimalMode::MinimumEnergy))
    };
    let mut world = World {
        vehicle,
        mutant,
        licence,
        phase: rng.uniform(0.0, core::f64::consts::TAU),
        engages_again: rng.uniform(0.0, 1.0) < 0.5,
        line: Line::new(&faults, Rng::from_name("line", number ^ seed)),
        station: vehicle.station(&faults, is_worst, mutant),
        program: Program::new(vehicle.profile(), law)?,
        elsewhere_since_ms: None,
        link: Some(LinkHost::start(vehicle, mutant, false, Timestamp::ZERO)?),
        guard_starts_at_ms: None,
        is_stop_sent: false,
        guard_died_at_ms: None,
        program_gone_at_ms: None,
        is_closing: false,
        is_suspended: false,
        suspended_ms: 0,
        pictures: VecDeque::new(),
        oracle: Oracle::new(vehicle.rest_limit_ms()),
        is_excluded: false,
        faults,
    };
    for at_ms in 0..LASTS_MS {
        world.advance(at_ms, trace)?;
    }
    Ok(RunResult {
        worst_ms: world.oracle.worst_ms(),
        moved: world.oracle.moved().to_vec(),
        violation: world.oracle.violation().cloned(),
        is_excluded: world.is_excluded,
        faults: world.faults,
    })
}

impl World {
    fn is_active(&self, kind: FaultKind, at_ms: u64) -> bool {
        self.faults.iter().any(|fault| fault.kind == kind && fault.is_active(at_ms))
    }

    fn begins(&self, kind: FaultKind, at_ms: u64) -> bool {
        self.faults.iter().any(|fault| fault.kind == kind && fault.from_ms == at_ms)
    }

    fn advance(&mut self, at_ms: u64, trace: &mut dyn FnMut(&str)) -> Result<()> {
        self.line.advance(at_ms);
        self.station.advance(&mut self.line, at_ms, trace);
        self.capture(at_ms);
        let is_suspended = self.is_active(FaultKind::Suspension, at_ms);
        let was_suspended = std::mem::replace(&mut self.is_suspended, is_suspended);
        if self.is_suspended {
            self.suspended_ms += 1;
        }
        // The monotonic clock stands still while the machine is suspended.
        let now = Timestamp::from_nanos((at_ms - self.suspended_ms) * 1_000_000);
        if !self.is_suspended {
            if was_suspended {
                self.oracle.excuse(at_ms);
                if let Some(link) = &mut self.link {
                    link.on_suspension();
                }
            }
            self.advance_link(now, at_ms);
            self.advance_program(was_suspended, now, at_ms)?;
        }
        self.judge(at_ms);
        Ok(())
    }

    /// The pictures of the camera: the boat swings to and fro before it.
    fn capture(&mut self, at_ms: u64) {
        if !at_ms.is_multiple_of(FRAME_MS) || self.is_active(FaultKind::VideoStalls, at_ms) {
            return;
        }
        let now = Timestamp::from_nanos((at_ms - self.suspended_ms) * 1_000_000);
        let boat_rad = 0.9 * (0.55 * at_ms as f64 / 1000.0 + self.phase).sin() - 0.9 * self.phase.sin();
        let is_out_of_sight = self.licence == Licence::Search && at_ms >= LOST_FROM_MS;
        let is_found = !is_out_of_sight && !self.is_active(FaultKind::TrackLost, at_ms);
        let picture = SeenPicture {
            captured: now,
            bearing_rad: is_found.then_some(boat_rad - self.station.pan_rad()),
            is_coasting: self.is_active(FaultKind::TrackCoasts, at_ms),
        };
        let late_ms = if self.is_active(FaultKind::VideoLate, at_ms) { VIDEO_LATE_MS } else { 0 };
        self.pictures.push_back((at_ms + VIDEO_LATENCY_MS + late_ms, picture));
    }

    fn is_program_running(&self, at_ms: u64) -> bool {
        self.program_gone_at_ms.is_none() && !self.is_active(FaultKind::ProgramStopped, at_ms)
    }

    fn advance_link(&mut self, now: Timestamp, at_ms: u64) {
        if self.begins(FaultKind::GuardKilled, at_ms) && self.link.take().is_some() {
            self.guard_died_at_ms = Some(at_ms);
            self.is_stop_sent = false;
            self.oracle.excuse(at_ms);
            if self.is_program_running(at_ms) {
                self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
            }
        }
        let is_there = self.program_gone_at_ms.is_none();
        let is_thread = !self.vehicle.has_guard() || self.mutant == Mutant::NoGuard;
        if is_thread && !self.is_program_running(at_ms) {
            return;
        }
        let Some(link) = &mut self.link else { return };
        if is_there {
            link.inbox.extend(self.program.outbox.drain(..));
        }
        link.advance(&mut self.line, is_there, now, at_ms);
        if let Some(is_stop_sent) = link.ended()
            && !self.is_closing
            && is_there
        {
            self.is_stop_sent = is_stop_sent;
            // A guard that took the program for gone has ended; the program starts another.
            self.link = None;
            self.program.reports.push_back(LinkReport::GuardLost("it has ended".to_owned()));
            self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
        }
    }

    fn advance_program(&mut self, was_suspended: bool, now: Timestamp, at_ms: u64) -> Result<()> {
        if self.begins(FaultKind::ProgramKilled, at_ms) {
            self.program_gone_at_ms.get_or_insert(at_ms);
        }
        if !self.is_program_running(at_ms) {
            let is_helpless = self.link.is_none()
                && self
                    .guard_died_at_ms
                    .is_some_and(|died| self.program_gone_at_ms.is_none_or(|gone| gone < died + TOGETHER_MS));
            self.is_excluded |= is_helpless;
            return Ok(());
        }
        if self.guard_starts_at_ms.is_some_and(|starts| starts <= at_ms) {
            self.guard_starts_at_ms = None;
            let may_be_turning = !self.is_stop_sent && !self.program.is_control_elsewhere();
            self.link = Some(LinkHost::start(self.vehicle, self.mutant, may_be_turning, now)?);
            self.program.reports.push_back(LinkReport::GuardLost("it was killed".to_owned()));
        } else if self.link.is_none() && self.guard_starts_at_ms.is_none() {
            self.guard_starts_at_ms = Some(at_ms + GUARD_STARTS_MS);
        }
        if let Some(link) = &mut self.link {
            self.program.reports.extend(link.reports.drain(..));
        }
        self.program.beat(now);
        if self.is_active(FaultKind::PilotHangs, at_ms) {
            return Ok(());
        }
        if was_suspended {
            self.pictures.clear();
            self.program.on_suspension(&mut self.oracle, now);
        }
        self.ask(now, at_ms);
        self.program.advance(&mut self.oracle, now);
        let mut newest = None;
        while let Some((_, picture)) = self.pictures.pop_front_if(|(due, _)| *due <= at_ms) {
            newest = Some(picture);
        }
        if let Some(picture) = newest {
            self.program.see(picture, &mut self.oracle, now, at_ms);
        }
        Ok(())
    }

    /// What the operator asks for.
    fn ask(&mut self, now: Timestamp, at_ms: u64) {
        if self.begins(FaultKind::ProgramEnds, at_ms) && !self.is_closing {
            self.is_closing = true;
            self.oracle.withdraw();
            self.program.end(now);
        }
        if self.is_closing {
            return;
        }
        if self.begins(FaultKind::OperatorStops, at_ms) {
            self.oracle.withdraw();
            self.program.request(OperatorRequest::Stop(StopCause::Operator), now);
            if self.mutant == Mutant::NoLatch {
                // A stop that does not last: the pilot goes on as if it had not been stopped.
                self.program.request(OperatorRequest::Engage, now);
            }
        }
        let ends_ms = self.faults.iter().map(|fault| fault.until_ms).max().unwrap_or(0);
        match self.licence {
            Licence::Follow => {
                let again = self.engages_again && at_ms == ends_ms + ENGAGES_AGAIN_MS;
                if at_ms == ENGAGES_AT_MS || again {
                    self.oracle.consent(Licence::Follow);
                    self.program.request(OperatorRequest::Engage, now);
                }
            }
            Licence::Search | Licence::Calibrate => self.ask_for_behaviour(ends_ms, now, at_ms),
            Licence::Nudge => {
                let is_held = at_ms >= ENGAGES_AT_MS && !self.is_active(FaultKind::OperatorStops, at_ms);
                if is_held && at_ms.is_multiple_of(NUDGE_INTERVAL_MS) {
                    self.oracle.consent(Licence::Nudge);
                    self.oracle.nudged(at_ms);
                    let pan = if at_ms % 4_000 < 2_000 { 1.0 } else { -1.0 };
                    self.program.request(OperatorRequest::Nudge(Nudge { pan, tilt: 0.5 }), now);
                }
            }
        }
    }

    /// Asks for a search of the boat that was followed, or for a calibration; in half of the runs once more after the faults.
    fn ask_for_behaviour(&mut self, ends_ms: u64, now: Timestamp, at_ms: u64) {
        let is_search = self.licence == Licence::Search;
        let (first_ms, request) = if is_search {
            (SEARCHES_AT_MS, OperatorRequest::Search)
        } else {
            (CALIBRATES_AT_MS, OperatorRequest::Calibrate)
        };
        let again_ms = ends_ms + ENGAGES_AGAIN_MS;
        let is_again = self.engages_again && at_ms == again_ms;
        if is_search && at_ms == ENGAGES_AT_MS {
            self.program.request(OperatorRequest::Engage, now);
        }
        if is_again {
            // A stop may have to be ended first.
            self.oracle.withdraw();
            self.program.request(OperatorRequest::Disengage, now);
        }
        if at_ms == first_ms || is_again {
            self.oracle.consent_to_behaviour(self.licence, at_ms);
            self.program.request(request, now);
        }
    }

    fn judge(&mut self, at_ms: u64) {
        if self.line.is_disturbed(at_ms) {
            self.oracle.excuse(at_ms + 1);
        }
        let is_unknown = self.line.is_disturbed(at_ms) || self.is_active(FaultKind::StatusWithheld, at_ms);
        if !self.station.is_anothers() || is_unknown || self.is_suspended {
            self.elsewhere_since_ms = None;
        } else {
            let since_ms = *self.elsewhere_since_ms.get_or_insert(at_ms);
            if self.station.is_meddled_with() && at_ms - since_ms > YIELDS_WITHIN_MS {
                self.oracle.meddles(at_ms, at_ms - since_ms);
            }
        }
        if self.is_suspended || self.line.is_disturbed(at_ms) || self.is_excluded {
            return;
        }
        // The motion is that of another commander.
        if self.station.is_anothers() {
            self.oracle.excuse(at_ms);
            return;
        }
        self.oracle.judge(at_ms, !self.station.rates().is_rest());
    }
}
