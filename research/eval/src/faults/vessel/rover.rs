//! The simulated ArduPilot boat.

use barrelman_vocab::{Timestamp, VesselCommand};
use barrelman_wire::mavlink::RoverBoat;
use barrelman_wire::mavlink::rover::{MANUAL, RoverDrive};
use barrelman_wire::mavlink::rover_boat::{HOLD, RoverBoatSettings};

use super::super::fault::{Fault, FaultKind};
use super::super::line::Line;
use super::super::mutant::Mutant;
use super::boat::Boat;

/// The boat.
pub(super) struct Rover {
    drive: RoverDrive,
    boat: RoverBoat,
    settings: RoverBoatSettings,
    faults: Vec<Fault>,
    /// The mutant of a boat without its own time-out.
    keeps_last: bool,
    last: VesselCommand,
    is_meddled_with: bool,
}

impl Rover {
    /// A boat; `is_ready`: in the mode in which it is driven from the start.
    pub(super) fn new(drive: RoverDrive, faults: &[Fault], is_ready: bool, mutant: Mutant) -> Self {
        let mode = if is_ready { drive.mode() } else { others_mode(drive) };
        let settings = RoverBoatSettings { mode, ..RoverBoatSettings::default() };
        Self {
            boat: RoverBoat::new(settings, Timestamp::ZERO),
            settings,
            drive,
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

/// The mode that the remote control's switch chooses to take the boat.
const fn others_mode(drive: RoverDrive) -> u32 {
    match drive {
        RoverDrive::Guided => MANUAL,
        RoverDrive::Manual => HOLD,
    }
}

/// Whether the boat describes a received message as a command.
fn is_command(text: &str) -> bool {
    text.starts_with("SET_POSITION_TARGET") || text.starts_with("MANUAL_CONTROL")
}

impl Boat for Rover {
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        let now = timestamp(at_ms);
        for fault in &self.faults {
            if fault.begins(FaultKind::StationReboots, at_ms) {
                self.boat = RoverBoat::new(self.settings, now);
            } else if fault.begins(FaultKind::ControlTaken, at_ms) {
                self.boat.switch_to(others_mode(self.drive));
            } else if fault.ends(FaultKind::ControlTaken, at_ms) {
                self.boat.switch_to(self.drive.mode());
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
                *is_meddled_with |= is_theirs && is_command(&text);
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
        let settings = RoverBoatSettings { mode: self.drive.mode(), ..self.settings };
        let mut boat = RoverBoat::new(settings, Timestamp::ZERO);
        boat.receive(packet, Timestamp::ZERO, &mut Vec::new(), |_| {});
        !boat.command(Timestamp::ZERO).is_neutral()
    }

    fn is_anothers(&self) -> bool {
        self.boat.mode() != self.drive.mode()
    }

    fn is_meddled_with(&self) -> bool {
        self.is_meddled_with
    }
}
