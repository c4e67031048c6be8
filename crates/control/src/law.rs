//! The camera law that a pilot works by.

use barrelman_vocab::{CameraCommand, PictureSize, Timestamp, VehicleProfile};

use crate::centring::{Centring, CentringGains};
use crate::percept::Percept;
use crate::schema::MotorSchema;

/// Which law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LawSettings {
    /// The paper's motor schema.
    #[default]
    Schema,
    /// A PID on the picture's centre.
    Centre(CentringGains),
}

/// A law with what it remembers.
#[derive(Debug, Clone)]
pub enum CameraLaw {
    /// The paper's motor schema, which remembers nothing.
    Schema(MotorSchema),
    /// A PID on the picture's centre.
    Centre(Centring),
}

impl CameraLaw {
    /// A law for a vehicle.
    pub fn new(settings: LawSettings, profile: &VehicleProfile) -> Self {
        match settings {
            LawSettings::Schema => Self::Schema(MotorSchema::new(profile.schema)),
            LawSettings::Centre(gains) => Self::Centre(Centring::new(gains, profile.limits)),
        }
    }

    /// What to ask of the camera for a percept of a picture of that size, taken at `captured`.
    pub fn command(&mut self, percept: &Percept, picture: PictureSize, captured: Timestamp) -> CameraCommand {
        match self {
            Self::Schema(schema) => schema.command(percept),
            Self::Centre(centring) => centring.command(percept, picture, captured),
        }
    }

    /// Forgets what was seen of a target: another one was selected.
    pub fn forget(&mut self) {
        match self {
            Self::Schema(_) => {}
            Self::Centre(centring) => centring.forget(),
        }
    }
}
