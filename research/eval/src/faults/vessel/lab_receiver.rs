//! The receiver of the laboratory's datagrams, with its time-out.

use barrelman_vocab::{Timestamp, VesselCommand};
use barrelman_wire::lab_udp::{LabReceiver, decode};

use super::super::fault::{Fault, FaultKind};
use super::super::line::Line;
use super::super::mutant::Mutant;
use super::boat::Boat;

/// The receiver.
pub(super) struct LabBoat {
    receiver: LabReceiver,
    faults: Vec<Fault>,
    /// What the receiver of the laboratory itself does: it keeps the last values for ever.
    keeps_last: bool,
    last: VesselCommand,
}

impl LabBoat {
    pub(super) fn new(faults: &[Fault], mutant: Mutant) -> Self {
        Self {
            receiver: LabReceiver::default(),
            faults: faults.to_vec(),
            keeps_last: mutant == Mutant::CommandsLast,
            last: VesselCommand::NEUTRAL,
        }
    }
}

fn timestamp(at_ms: u64) -> Timestamp {
    Timestamp::from_nanos(at_ms * 1_000_000)
}

impl Boat for LabBoat {
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        if self.faults.iter().any(|fault| fault.begins(FaultKind::StationReboots, at_ms)) {
            self.receiver = LabReceiver::default();
        }
        while let Some(packet) = line.arrived_up(at_ms) {
            self.receiver.received(&packet, timestamp(at_ms));
            self.last = decode(&packet).unwrap_or(self.last);
            trace(&format!("{at_ms} ms: {:?}", decode(&packet)));
        }
    }

    fn command(&self, at_ms: u64) -> VesselCommand {
        if self.keeps_last { self.last } else { self.receiver.command(timestamp(at_ms)) }
    }

    fn tells_to_move(&self, packet: &[u8]) -> bool {
        decode(packet).is_some_and(|command| !command.is_neutral())
    }
}
