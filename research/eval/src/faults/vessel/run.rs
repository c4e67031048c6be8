//! One run with a boat: thirteen seconds of the world, millisecond by millisecond.

use anyhow::Result;
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_vocab::{MarkKind, VesselOrder};

use super::super::fault::{self, FaultKind};
use super::super::machine::{Machine, Moment};
use super::super::mutant::Mutant;
use super::super::picture::{FRAME_MS, SeenPicture, boat_bearing_rad};
use super::super::run::LASTS_MS;
use super::super::run_result::RunResult;
use super::super::station::TICK_S;
use super::super::video_path::VideoPath;
use super::boat::Boat;
use super::oracle::{VesselLicence, VesselOracle};
use super::program::VesselProgram;
use super::script::{Desk, Script};
use super::vessel_kind::Vessel;
use crate::rng_of_name::rng_of_name;

/// Interval between two reports of height and tilt, ms.
const HEIGHT_INTERVAL_MS: u64 = 200;
/// A boat that another commander steers is left alone after this time on a line without faults, ms.
const YIELDS_WITHIN_MS: u64 = 1_500;

/// Share of the guided runs over the water in which a tracker holds the mark.
const HELD_SHARE: f64 = 0.05;
/// The name of ways to a mark that a tracker holds, among the licences.
pub(crate) const HELD_MARK: &str = "guided to a held mark";

struct World {
    vessel: Vessel,
    machine: Machine<VesselOrder>,
    boat: Box<dyn Boat>,
    program: VesselProgram,
    script: Script,
    oracle: VesselOracle,
    phase: f64,
    pan_rad: f64,
    video: VideoPath,
    /// Until when line and guard are not whole, ms.
    disturbed_until_ms: u64,
    /// Since when another commander has steered the boat, on a line without faults, ms.
    elsewhere_since_ms: Option<u64>,
}

/// Runs the run with this number. `trace` takes what the boat receives.
///
/// # Errors
/// If the boat has no profile.
pub(crate) fn run(
    vessel: Vessel,
    number: u64,
    seed: u64,
    mutant: Mutant,
    trace: &mut dyn FnMut(&str),
) -> Result<RunResult> {
    let mut rng = rng_of_name("faults of boats", seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let faults = fault::draw(number, &vessel.faults(), &mut rng);
    let licence = match rng.uniform() {
        ..0.5 => Some(VesselLicence::Guided),
        ..0.85 => Some(VesselLicence::ByHand),
        _ => None,
    };
    // In the picture no way is kept.
    let is_over_water = rng.uniform() < 0.5 || vessel == Vessel::LabUdpKeepingWay;
    let guidance = if is_over_water { GuidanceLaw::LineOfSight } else { GuidanceLaw::Laboratory };
    // Go asks a boat for its mode; a helm does not.
    let is_ready = licence == Some(VesselLicence::ByHand) || rng.uniform() < 0.5;
    // Few: trackers read every picture.
    let has_person = is_over_water
        && licence == Some(VesselLicence::Guided)
        && mutant == Mutant::None
        && rng_of_name("held mark", number ^ seed).uniform() < HELD_SHARE;
    let marks = if has_person { MarkKind::Person } else { MarkKind::Place };
    let mut world = World {
        vessel,
        boat: vessel.boat(&faults, is_ready, mutant),
        program: VesselProgram::new(vessel.profile()?, guidance, marks, mutant),
        script: Script { licence, engages_again: rng.uniform() < 0.5, mutant, is_helm_held: false },
        oracle: VesselOracle::new(vessel.own_limit_ms(&faults), vessel.profile()?.fail_safe),
        phase: rng.between(0.0, core::f64::consts::TAU),
        machine: Machine::start(vessel.link_plan(mutant)?, faults, rng_of_name("line", number ^ seed)),
        pan_rad: 0.0,
        video: VideoPath::new(mutant),
        disturbed_until_ms: 0,
        elsewhere_since_ms: None,
    };
    for at_ms in 0..LASTS_MS {
        world.advance(at_ms, trace);
    }
    Ok(RunResult {
        worst_ms: world.oracle.worst_ms().to_vec(),
        moved: world.moved(),
        violation: world.oracle.violation().cloned(),
        is_excluded: false,
        faults: world.machine.faults,
    })
}

impl World {
    /// The licences with which the boat moved, and whether it went to a held mark.
    fn moved(&self) -> Vec<&'static str> {
        let held = self.program.went_to_held_mark.then_some(HELD_MARK);
        self.oracle.moved().into_iter().chain(held).collect()
    }

    fn advance(&mut self, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        self.machine.line.advance(at_ms);
        self.boat.advance(&mut self.machine.line, at_ms, trace);
        self.pan_rad += self.program.pan_rad_per_s() * TICK_S;
        self.capture(at_ms);
        if let Some(moment) = self.machine.begin(at_ms) {
            if moment.was_suspended {
                self.oracle.resume(at_ms);
            }
            if self.machine.advance_link(&mut self.program.end, moment) {
                self.oracle.strike_guard(at_ms);
            }
            self.oracle.set_live_guard(self.machine.has_live_guard());
            self.advance_program(moment);
        }
        self.judge(at_ms);
    }

    /// The pictures of the camera: the boat swings to and fro before it.
    fn capture(&mut self, at_ms: u64) {
        if !at_ms.is_multiple_of(FRAME_MS) || self.machine.is_active(FaultKind::VideoStalls, at_ms) {
            return;
        }
        let boat_rad = self.vessel.swing() * boat_bearing_rad(self.phase, at_ms);
        let is_found = !self.machine.is_active(FaultKind::TrackLost, at_ms);
        let picture = SeenPicture {
            bearing_rad: is_found.then_some(boat_rad - self.pan_rad),
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
        if self.machine.begins(FaultKind::ProgramEnds, at_ms) && !self.machine.is_closing {
            self.machine.is_closing = true;
            self.oracle.withdraw();
            self.program.close(now);
        }
        if !self.machine.is_closing {
            let Self { program, oracle, machine, .. } = self;
            self.script.act(&mut Desk { program, oracle, faults: &machine.faults, now, at_ms });
        }
        if at_ms.is_multiple_of(HEIGHT_INTERVAL_MS) {
            self.program.report_height(now);
        }
        self.program.advance(&mut self.oracle, now);
        if !self.machine.is_closing {
            self.oracle.program_runs(at_ms);
        }
        if let Some(arrived) = self.video.receive(at_ms, now) {
            let arrival = self.program.see(arrived, now);
            self.oracle.saw(arrival, at_ms);
        }
    }

    fn judge(&mut self, at_ms: u64) {
        let is_line_disturbed = self.machine.line.is_disturbed(at_ms);
        // A guard that hung is replaced by one that opens the port at once, and speaks at once where the boat
        // need not be heard.
        let is_replaced = self.machine.replaces_hung_guard() && self.vessel.is_spoken_to_unheard();
        let is_guard_gone = !(self.machine.has_link() || is_replaced) || self.machine.is_excluded();
        if is_line_disturbed || is_guard_gone || self.machine.is_suspended() {
            self.disturbed_until_ms = at_ms + self.vessel.settles_ms();
        }
        if at_ms <= self.disturbed_until_ms {
            self.oracle.disturb(at_ms);
        }
        if !self.boat.is_anothers() || is_line_disturbed || self.machine.is_suspended() {
            self.elsewhere_since_ms = None;
        } else {
            let since_ms = at_ms - *self.elsewhere_since_ms.get_or_insert(at_ms);
            if self.boat.is_meddled_with() && since_ms > YIELDS_WITHIN_MS {
                self.oracle.meddles(at_ms, since_ms);
            }
        }
        if self.machine.sent().iter().any(|packet| self.boat.tells_to_move(packet)) {
            self.oracle.sent_motion(at_ms);
        }
        self.oracle.judge(at_ms, self.boat.command(at_ms));
    }
}
