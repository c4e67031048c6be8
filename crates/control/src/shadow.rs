//! What the paper's schema would have done: the schema on the same bearings, with a camera of its own.
//!
//! A law's merit shows beside what it replaces. From where the target was seen and where the camera pointed follows its
//! bearing; the shadow looks at that bearing with a camera that only ever obeyed the schema, and commands it by what it
//! sees. Where the target would have been out of the shadow's picture it sees nothing, and rests. O(1), no allocation.

use core::time::Duration;

use barrelman_vocab::{CameraCommand, ImagePoint, Timestamp, VehicleProfile};

use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::percept::Percept;
use crate::schema::MotorSchema;
use crate::view::View;

/// The schema with the camera that it would have had.
#[derive(Debug, Clone)]
pub struct ShadowController {
    schema: MotorSchema,
    camera: CameraModel,
    coast_motion: Duration,
    last: Option<Timestamp>,
}

/// What the shadow saw and asked for at one look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowStep {
    /// Where it would have seen the target, also beyond its picture's border.
    pub position: ImagePoint,
    /// P there.
    pub p: f64,
    /// Whether that is within the picture.
    pub in_picture: bool,
    /// What the schema would have asked for.
    pub command: CameraCommand,
}

impl ShadowController {
    /// A shadow whose camera points where the vehicle's does at the start.
    pub fn new(profile: &VehicleProfile) -> Self {
        Self {
            schema: MotorSchema::new(profile.motor_schema_rates),
            camera: CameraModel::new(profile.camera, profile.limits),
            coast_motion: profile.coast_motion,
            last: None,
        }
    }

    /// The target was seen with `camera`; what the schema would have seen and done.
    pub fn step(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> ShadowStep {
        if let Some(last) = self.last.filter(|last| input.now > last.plus(self.coast_motion)) {
            // Nothing was seen for so long: the schema's camera, too, would have come to rest.
            self.camera.apply_command(CameraCommand::REST, last.plus(self.coast_motion));
        }
        let focal_px = camera.focal_px(input.captured, input.picture);
        let view = |model: &CameraModel| {
            let (pan, tilt) = model.angles_at(input.captured);
            View::new(focal_px, pan, tilt)
        };
        let position = view(&self.camera).project(view(camera).unproject(input.percept.position));
        let percept = Percept::new(position, input.region);
        let (half_width, half_height) =
            (0.5 * f64::from(input.picture.width), 0.5 * f64::from(input.picture.height));
        let in_picture = position.x.abs() <= half_width && position.y.abs() <= half_height;
        let command = if in_picture { self.schema.command(&percept) } else { CameraCommand::REST };
        self.camera.apply_command(command, input.now);
        self.last = Some(input.now);
        ShadowStep { position, p: percept.p, in_picture, command }
    }
}
