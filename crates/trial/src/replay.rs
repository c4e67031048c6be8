//! A recording through a pilot again, and the comparison with what it did then.

use barrelman_pilot::{Input, Pilot};
use barrelman_vocab::{Timestamp, VehicleProfile};

use crate::records::RecordedOutcome;

/// A pilot that is fed from a recording.
pub struct Replay {
    pilot: Pilot,
    profile: VehicleProfile,
}

impl Replay {
    /// A replay through a fresh pilot.
    pub fn new(pilot: Pilot, profile: VehicleProfile) -> Self {
        Self { pilot, profile }
    }

    /// Takes an input as the pilot took it then.
    pub fn step(&mut self, step: u64, now: Timestamp, input: Input<'_>) -> RecordedOutcome {
        let outcome = self.pilot.step(input, now);
        RecordedOutcome::new(step, &outcome, self.profile.to_vehicle(outcome.command))
    }
}

/// How many outcomes were the same, and the first that was not.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// Outcomes compared.
    pub outcomes: u64,
    /// Outcomes whose command, inside or as sent, differs in any bit.
    pub commands_differ: u64,
    /// Outcomes that differ in anything: track, percept, mode, ...
    pub outcomes_differ: u64,
    /// The first outcome whose command differs, as recorded and as replayed; else the first that differs at all.
    pub first: Option<Box<(RecordedOutcome, RecordedOutcome)>>,
}

impl Comparison {
    /// Compares one outcome.
    pub fn add(&mut self, recorded: &RecordedOutcome, replayed: &RecordedOutcome) {
        self.outcomes += 1;
        let command_differs = command_bits(recorded) != command_bits(replayed);
        let differs = command_differs || recorded != replayed;
        self.outcomes_differ += u64::from(differs);
        if differs && (self.first.is_none() || (command_differs && self.commands_differ == 0)) {
            self.first = Some(Box::new((recorded.clone(), replayed.clone())));
        }
        self.commands_differ += u64::from(command_differs);
    }
}

fn command_bits(outcome: &RecordedOutcome) -> [u64; 4] {
    [outcome.command.pan, outcome.command.tilt, outcome.rates.yaw, outcome.rates.pitch]
        .map(|rate| rate.radians_per_second().to_bits())
}
