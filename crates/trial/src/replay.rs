//! Replay of a recording through the pilot, and the comparison of its outcomes with the recorded ones.

use barrelman_pilot::{Input, Pilot};
use barrelman_vocab::{Timestamp, VehicleProfile, VesselCommand};

use crate::records::RecordedOutcome;

/// A pilot that receives the inputs of a recording.
pub struct Replay {
    pilot: Pilot,
    profile: VehicleProfile,
}

impl Replay {
    /// A replay through a pilot that has not been stepped yet.
    pub fn new(pilot: Pilot, profile: VehicleProfile) -> Self {
        Self { pilot, profile }
    }

    /// Steps the pilot with a recorded input, at the recorded time.
    pub fn step(&mut self, step: u64, now: Timestamp, input: Input<'_>) -> RecordedOutcome {
        let outcome = self.pilot.step(input, now);
        RecordedOutcome::new(step, &outcome, self.profile.to_vehicle(outcome.command))
    }
}

/// Counts of equal and different outcomes, and the first difference.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReplayComparison {
    /// Number of outcomes compared.
    pub outcomes: u64,
    /// Number of outcomes whose command, or whose rates as sent, differ in any bit.
    pub commands_differ: u64,
    /// Number of outcomes that differ in any field: track, percept, mode, ...
    pub outcomes_differ: u64,
    /// The first outcome whose command differs, else the first that differs in any field: recorded, replayed.
    pub first_difference: Option<Box<(RecordedOutcome, RecordedOutcome)>>,
}

impl ReplayComparison {
    /// Compares the recorded and the replayed outcome of one step.
    pub fn add(&mut self, recorded: &RecordedOutcome, replayed: &RecordedOutcome) {
        self.outcomes += 1;
        let command_differs = command_bits(recorded) != command_bits(replayed);
        let differs = command_differs || recorded != replayed;
        self.outcomes_differ += u64::from(differs);
        if differs && (self.first_difference.is_none() || (command_differs && self.commands_differ == 0)) {
            self.first_difference = Some(Box::new((recorded.clone(), replayed.clone())));
        }
        self.commands_differ += u64::from(command_differs);
    }
}

fn command_bits(outcome: &RecordedOutcome) -> [u64; 6] {
    let rates = [outcome.command.pan, outcome.command.tilt, outcome.rates.yaw, outcome.rates.pitch];
    let [pan, tilt, yaw, pitch] = rates.map(|rate| rate.radians_per_second().to_bits());
    let boat = outcome.vessel.as_ref().map_or(VesselCommand::NEUTRAL, |vessel| vessel.command);
    [pan, tilt, yaw, pitch, boat.throttle.to_bits(), boat.rudder.to_bits()]
}
