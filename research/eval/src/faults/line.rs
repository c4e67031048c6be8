//! The simulated line between the port and the ground station, both ways, with its faults.

use std::collections::VecDeque;

use barrelman_vocab::rng::SplitMix64;

use super::fault::{self, Fault, FaultKind};

/// Time of a packet on the line, ms.
const LATENCY_MS: u64 = 3;
/// Additional time while the line delays, ms.
pub(super) const DELAY_MS: u64 = 400;
/// Share of the packets that a lossy line loses.
const LOST_SHARE: f64 = 0.5;
/// Share of the bytes that a damaging line changes.
const DAMAGED_SHARE: f64 = 0.005;

/// One direction of the line.
#[derive(Debug, Default)]
struct Way(VecDeque<(u64, Vec<u8>)>);

/// The line.
#[derive(Debug)]
pub(super) struct Line {
    up: Way,
    down: Way,
    faults: Vec<Fault>,
    rng: SplitMix64,
    was_cut: bool,
}

impl Line {
    pub(super) fn new(faults: &[Fault], rng: SplitMix64) -> Self {
        let faults = faults.iter().copied().filter(|fault| fault.kind.is_of_line()).collect();
        Self { up: Way::default(), down: Way::default(), faults, rng, was_cut: false }
    }

    pub(super) fn is_active(&self, kind: FaultKind, at_ms: u64) -> bool {
        fault::active(&self.faults, kind, at_ms).is_some()
    }

    /// Whether a fault of the line is active, or what it delayed is still on its way.
    pub(super) fn is_disturbed(&self, at_ms: u64) -> bool {
        self.faults.iter().any(|fault| {
            let delay_ms = if fault.kind == FaultKind::LineDelays { DELAY_MS + LATENCY_MS } else { 0 };
            (fault.from_ms..fault.until_ms + delay_ms).contains(&at_ms)
        })
    }

    /// Whether what the ground station sends arrives at once, and undamaged.
    pub(super) fn is_heard(&self, at_ms: u64) -> bool {
        !self.faults.iter().any(|fault| fault.kind != FaultKind::CommandsLost && fault.is_active(at_ms))
    }

    /// Lets time pass. A line that is cut loses what is on its way, but for a part of a packet to the ground
    /// station.
    pub(super) fn advance(&mut self, at_ms: u64) {
        let is_cut = self.is_active(FaultKind::LineCut, at_ms);
        if is_cut && !self.was_cut {
            self.up.0.truncate(1);
            if let Some((_, packet)) = self.up.0.front_mut() {
                let kept = self.rng.between(0.0, packet.len() as f64) as usize;
                packet.truncate(kept);
            }
            self.down.0.clear();
        }
        self.was_cut = is_cut;
    }

    /// Sends a packet to the ground station.
    pub(super) fn send_up(&mut self, packet: Vec<u8>, at_ms: u64) {
        if self.is_active(FaultKind::CommandsLost, at_ms) {
            return;
        }
        let passed = self.passed(packet, at_ms);
        self.up.0.extend(passed);
    }

    /// Sends bytes of the ground station.
    pub(super) fn send_down(&mut self, bytes: Vec<u8>, at_ms: u64) {
        if self.is_active(FaultKind::LineCut, at_ms) {
            return;
        }
        let passed = self.passed(bytes, at_ms);
        self.down.0.extend(passed);
    }

    /// The next packet that has reached the ground station.
    pub(super) fn arrived_up(&mut self, at_ms: u64) -> Option<Vec<u8>> {
        self.up.0.pop_front_if(|(due, _)| *due <= at_ms).map(|(_, packet)| packet)
    }

    /// The next bytes that have reached the port.
    pub(super) fn arrived_down(&mut self, at_ms: u64) -> Option<Vec<u8>> {
        self.down.0.pop_front_if(|(due, _)| *due <= at_ms).map(|(_, packet)| packet)
    }

    fn passed(&mut self, mut packet: Vec<u8>, at_ms: u64) -> Vec<(u64, Vec<u8>)> {
        if packet.is_empty() || self.is_active(FaultKind::LineSilent, at_ms) {
            return Vec::new();
        }
        if self.is_active(FaultKind::LineLosesPackets, at_ms) && self.rng.uniform() < LOST_SHARE {
            return Vec::new();
        }
        if self.is_active(FaultKind::LineDamagesBytes, at_ms) {
            for byte in &mut packet {
                if self.rng.uniform() < DAMAGED_SHARE {
                    *byte = self.rng.between(0.0, 256.0) as u8;
                }
            }
        }
        let delay_ms = if self.is_active(FaultKind::LineDelays, at_ms) { DELAY_MS } else { 0 };
        let due = at_ms + LATENCY_MS + delay_ms;
        let copies = if self.is_active(FaultKind::LineRepeats, at_ms) { 2 } else { 1 };
        vec![(due, packet); copies]
    }
}
