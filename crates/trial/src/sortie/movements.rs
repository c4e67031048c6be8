//! How often and how far a camera moves.

use barrelman_vocab::CameraCommand;
use serde::{Deserialize, Serialize};

/// The movements of a camera.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Movements {
    /// Number of commands that start from rest.
    pub moves: u64,
    /// Integral of |rate| over both axes, rad.
    pub travel_rad: f64,
}

/// Counts the movements of a camera by the commands in force.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MovementCounter {
    movements: Movements,
    in_force: CameraCommand,
}

impl MovementCounter {
    /// The command in force has lasted for this time, and is followed by another.
    pub(super) fn add(&mut self, lasted_s: f64, next: CameraCommand) {
        let speed =
            self.in_force.pan.radians_per_second().abs() + self.in_force.tilt.radians_per_second().abs();
        self.movements.travel_rad += speed * lasted_s;
        self.movements.moves += u64::from(self.in_force.is_rest() && !next.is_rest());
        self.in_force = next;
    }

    pub(super) const fn movements(&self) -> Movements {
        self.movements
    }
}
