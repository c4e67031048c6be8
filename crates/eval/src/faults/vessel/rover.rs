//! The simulated ArduPilot boat.

use barrelman_vocab::{Timestamp, VesselCommand};
use barrelman_wire::mavlink::RoverBoat;
use barrelman_wire::mavlink::rover::GUIDED;
use barrelman_wire::mavlink::rover_boat::{MANUAL, RoverBoatSettings};

use super::super::fault::{Fault, FaultKind};
use super::super::line::Line;
use super::super::mutant::Mutant;
use super::boat::Boat;

/// The boat.
pub(super) struct Rover {
    boat: RoverBoat,
    settings: RoverBoatSettings,
    faults: Vec<Fault>,
    /// The mutant of a boat without its own time-out.
    keeps_last: bool,
    last: VesselCommand,
    is_meddled_with: bool,
}

impl Rover {
    /// A boat; `is_guided`: in the mode GUIDED from the start.
    pub(super) fn new(faults: &[Fault], is_guided: bool, mutant: Mutant) -> Self {
        let mode = if is_guided { GUIDED } else { MANUAL };
        let settings = RoverBoatSettings { mode, ..RoverBoatSettings::default() };
        Self {
            boat: RoverBoat::new(settings, Timestamp::ZERO),
            settings,
            faults: faults.to_vec(),
            keeps_last: mutant == Mutant::CommandsLast,
            last: VesselCommand::NEUTRAL,
            is_meddled_with: false,
        }
    }
}

fn timestamp(at_ms: u64) -> Timestamp {
    Timestamp::from_nanos(at_ms * 1_000_000)
}

/// Whether the boat describes a received message as a set-point.
fn is_set_point(text: &str) -> bool {
    text.starts_with("SET_POSITION_TARGET")
}

impl Boat for Rover {
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        let now = timestamp(at_ms);
        for fault in &self.faults {
            if fault.begins(FaultKind::StationReboots, at_ms) {
                self.boat = RoverBoat::new(self.settings, now);
            } else if fault.begins(FaultKind::ControlTaken, at_ms) {
                self.boat.switch_to(MANUAL);
            } else if fault.ends(FaultKind::ControlTaken, at_ms) {
                self.boat.switch_to(GUIDED);
            } else if fault.begins(FaultKind::BoatDisarmed, at_ms) {
                self.boat.arm(false);
            } else if fault.ends(FaultKind::BoatDisarmed, at_ms) {
                self.boat.arm(true);
            }
        }
        let mut out = Vec::new();
        self.is_meddled_with = false;
        while let Some(packet) = line.arrived_up(at_ms) {
            let is_theirs = self.is_anothers();
            let is_meddled_with = &mut self.is_meddled_with;
            self.boat.receive(&packet, now, &mut out, |text| {
                *is_meddled_with |= is_theirs && is_set_point(&text);
                trace(&format!("{at_ms} ms: {text}"));
            });
            let command = self.boat.command(now);
            if !command.is_neutral() {
                self.last = command;
            }
        }
        self.boat.advance(now, &mut out);
        for packet in out {
            line.send_down(packet, at_ms);
        }
    }

    fn command(&self, at_ms: u64) -> VesselCommand {
        if self.keeps_last && !self.is_anothers() { self.last } else { self.boat.command(timestamp(at_ms)) }
    }

    fn tells_to_move(&self, packet: &[u8]) -> bool {
        let settings = RoverBoatSettings { mode: GUIDED, ..self.settings };
        let mut boat = RoverBoat::new(settings, Timestamp::ZERO);
        boat.receive(packet, Timestamp::ZERO, &mut Vec::new(), |_| {});
        !boat.command(Timestamp::ZERO).is_neutral()
    }

    fn is_anothers(&self) -> bool {
        self.boat.mode() != GUIDED
    }

    fn is_meddled_with(&self) -> bool {
        self.is_meddled_with
    }
}
