//! The shadow controller: the motor schema, simulated on the same target bearings with a simulated camera, as
//! a reference for another law.
//!
//! The measured image point and the camera's pointing give the target's bearing. The shadow controller
//! projects that bearing into the view of a second camera model, which only the motor schema commands. While
//! the target is outside of the second camera's picture, the shadow controller commands rest. Work per step:
//! O(1), no allocation.

use core::time::Duration;

use barrelman_vocab::{CameraCommand, ImagePoint, Timestamp, VehicleProfile};

use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::motor_schema::MotorSchema;
use crate::percept::Percept;
use crate::view::View;

/// The motor schema with its simulated camera.
#[derive(Debug, Clone)]
pub struct ShadowController {
    motor_schema: MotorSchema,
    camera: CameraModel,
    coast_motion: Duration,
    last: Option<Timestamp>,
}

/// Result of one step of the shadow controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowStep {
    /// Position of the target in the simulated picture; may lie outside of the picture.
    pub position: ImagePoint,
    /// P of that position.
    pub p: f64,
    /// Whether the position lies in the picture.
    pub in_picture: bool,
    /// Command of the motor schema.
    pub command: CameraCommand,
}

impl ShadowController {
    /// A shadow controller whose camera starts with the vehicle's initial pointing.
    pub fn new(profile: &VehicleProfile) -> Self {
        Self {
            motor_schema: MotorSchema::new(profile.motor_schema_rates),
            camera: CameraModel::of(profile),
            coast_motion: profile.coast_motion,
            last: None,
        }
    }

    /// Processes one measurement of the target that was made with `camera`.
    pub fn step(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> ShadowStep {
        if let Some(last) = self.last.filter(|last| input.now > last.plus(self.coast_motion)) {
            // After such a gap the safety rule would have stopped the simulated camera as well.
            self.camera.apply_command(CameraCommand::REST, last.plus(self.coast_motion));
        }
        let focal_px = camera.focal_px(input.captured, input.picture);
        let view_of = |model: &CameraModel| {
            let (pan, tilt) = model.angles_at(input.captured);
            View::new(focal_px, pan, tilt)
        };
        let position = view_of(&self.camera).project(view_of(camera).unproject(input.percept.position));
        let percept = Percept::new(position, input.region);
        let (half_width, half_height) =
            (0.5 * f64::from(input.picture.width), 0.5 * f64::from(input.picture.height));
        let in_picture = position.x.abs() <= half_width && position.y.abs() <= half_height;
        let command = if in_picture { self.motor_schema.command(&percept) } else { CameraCommand::REST };
        self.camera.apply_command(command, input.now);
        self.last = Some(input.now);
        ShadowStep { position, p: percept.p, in_picture, command }
    }
}
