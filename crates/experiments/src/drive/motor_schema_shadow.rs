//! The paper's motor schema simulated beside a drive, for comparison.
//!
//! The shadow uses only the tracker's output and the camera commands. It changes nothing in the drive.

use barrelman_control::{CameraModel, LawInput, ShadowController};
use barrelman_pilot::Outcome;
use barrelman_vocab::{CameraCommand, Timestamp, VehicleProfile};

/// The motor schema with a model of the camera that it would have moved.
pub struct MotorSchemaShadow {
    camera: CameraModel,
    shadow: ShadowController,
    /// Time of capture of the last localisation used.
    last_captured: Option<Timestamp>,
    p: Option<f64>,
    command: CameraCommand,
}

impl MotorSchemaShadow {
    /// A shadow at the start of a drive.
    pub fn new(profile: &VehicleProfile) -> Self {
        Self {
            camera: CameraModel::new(profile.camera, profile.limits),
            shadow: ShadowController::new(profile),
            last_captured: None,
            p: None,
            command: CameraCommand::REST,
        }
    }

    /// Follows a step of the drive. A step without a new localisation only updates the command in force.
    pub fn step(&mut self, now: Timestamp, outcome: &Outcome) {
        match (outcome.track.localisation(), outcome.percept, outcome.region) {
            (Some(seen), Some(percept), Some(region)) if self.last_captured != Some(seen.captured) => {
                self.last_captured = Some(seen.captured);
                let (picture, captured) = (seen.picture, seen.captured);
                let input = LawInput { percept: &percept, region, picture, captured, is_measured: true, now };
                let step = self.shadow.step(&input, &self.camera);
                (self.p, self.command) = (Some(step.p), step.command);
            }
            (Some(_), Some(_), Some(_)) => {}
            _ => (self.p, self.command) = (None, CameraCommand::REST),
        }
        self.camera.apply_command(outcome.command, now);
    }

    /// What the motor schema would command.
    pub const fn command(&self) -> CameraCommand {
        self.command
    }

    /// P under the motor schema; `None` while the target is not localised.
    pub const fn p(&self) -> Option<f64> {
        self.p
    }
}
