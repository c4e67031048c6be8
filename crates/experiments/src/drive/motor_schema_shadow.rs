//! What the paper's schema would have made of a drive, while it goes on.
//!
//! From what the tracker says and what the camera is told, and from nothing else: it stands beside the drive and changes
//! nothing in it.

use barrelman_control::{CameraModel, LawInput, ShadowController};
use barrelman_pilot::Outcome;
use barrelman_vocab::{Timestamp, VehicleProfile};

/// The schema, with the camera that it would have had.
pub struct MotorSchemaShadow {
    camera: CameraModel,
    shadow: ShadowController,
    looked: Option<Timestamp>,
    p: Option<f64>,
}

impl MotorSchemaShadow {
    /// A shadow at a drive's start.
    pub fn new(profile: &VehicleProfile) -> Self {
        Self {
            camera: CameraModel::new(profile.camera, profile.limits),
            shadow: ShadowController::new(profile),
            looked: None,
            p: None,
        }
    }

    /// A step of the drive. A step that brings no new picture only tells what the camera was told.
    pub fn step(&mut self, now: Timestamp, outcome: &Outcome) {
        match (outcome.track.localisation(), outcome.percept, outcome.region) {
            (Some(seen), Some(percept), Some(region)) if self.looked != Some(seen.captured) => {
                self.looked = Some(seen.captured);
                let (picture, captured) = (seen.picture, seen.captured);
                let input = LawInput { percept: &percept, region, picture, captured, is_measured: true, now };
                self.p = Some(self.shadow.step(&input, &self.camera).p);
            }
            (Some(_), Some(_), Some(_)) => {}
            _ => self.p = None,
        }
        self.camera.apply_command(outcome.command, now);
    }

    /// P as the schema would have kept it; `None` while the target is not seen.
    pub const fn p(&self) -> Option<f64> {
        self.p
    }
}
