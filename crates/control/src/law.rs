//! The camera law that a pilot works by, with the camera as it imagines it.

use core::fmt;

use barrelman_vocab::{Angle, CameraCommand, MotionPrior, PictureSize, Timestamp, VehicleProfile};

use crate::camera_model::CameraModel;
use crate::centring::{Centring, CentringGains};
use crate::law_input::LawInput;
use crate::optimal::{OptimalLaw, OptimalSettings};
use crate::schema::MotorSchema;

/// Turns what is seen into what is asked of the camera.
pub trait Law: Send {
    /// What to ask of the camera for what is seen.
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand;

    /// This command is in force from `now` on: what the law asked for, or what safety made of it.
    fn on_command_applied(&mut self, _command: CameraCommand, _now: Timestamp) {}

    /// Forgets what was seen of a target: another one was selected.
    fn reset_target(&mut self) {}
}

impl Law for MotorSchema {
    fn command(&mut self, input: &LawInput<'_>, _: &CameraModel) -> CameraCommand {
        Self::command(self, input.percept)
    }
}

impl Law for Centring {
    fn command(&mut self, input: &LawInput<'_>, _: &CameraModel) -> CameraCommand {
        Self::command(self, input.percept, input.picture, input.captured)
    }

    fn reset_target(&mut self) {
        Self::reset_target(self);
    }
}

impl Law for OptimalLaw {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        Self::command(self, input, camera)
    }

    fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        Self::on_command_applied(self, command, now);
    }

    fn reset_target(&mut self) {
        Self::reset_target(self);
    }
}

/// Which law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LawSettings {
    /// The paper's motor schema.
    #[default]
    MotorSchema,
    /// A PID on the picture's centre.
    Centring(CentringGains),
    /// Both axes at once with the least energy.
    Optimal(OptimalSettings),
}

/// A law with the camera that it imagines.
pub struct CameraLaw {
    camera: CameraModel,
    law: Box<dyn Law>,
}

impl CameraLaw {
    /// A law for a vehicle.
    pub fn new(settings: LawSettings, profile: &VehicleProfile) -> Self {
        let law: Box<dyn Law> = match settings {
            LawSettings::MotorSchema => Box::new(MotorSchema::new(profile.motor_schema_rates)),
            LawSettings::Centring(gains) => Box::new(Centring::new(gains, profile.limits)),
            LawSettings::Optimal(settings) => Box::new(OptimalLaw::new(&settings, profile)),
        };
        Self::from_law(law, profile)
    }

    /// A law of one's own for a vehicle.
    pub fn from_law(law: Box<dyn Law>, profile: &VehicleProfile) -> Self {
        Self { camera: CameraModel::new(profile.camera, profile.limits), law }
    }

    /// What to ask of the camera for what is seen.
    pub fn command(&mut self, input: &LawInput<'_>) -> CameraCommand {
        self.camera.advance_to(input.now);
        self.law.command(input, &self.camera)
    }

    /// How the picture shifted between two times of capture because the camera turned.
    pub fn motion_prior(&self, from: Timestamp, to: Timestamp, picture: PictureSize) -> MotionPrior {
        self.camera.motion_prior(from, to, picture)
    }

    /// This command is in force from `now` on, whoever wanted it.
    pub fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        self.camera.apply_command(command, now);
        self.law.on_command_applied(command, now);
    }

    /// The gimbal reported the camera's tilt, as it was at `at`.
    pub fn on_tilt_report(&mut self, tilt: Angle, at: Timestamp) {
        self.camera.correct_tilt(tilt, at);
    }

    /// The camera reported that its picture shows so much from the left edge to the right, from `at` on: it zooms.
    pub fn on_field_of_view_report(&mut self, angle: Angle, at: Timestamp) {
        self.camera.set_field_of_view(angle, at);
    }

    /// Forgets what was seen of a target: another one was selected.
    pub fn reset_target(&mut self) {
        self.law.reset_target();
    }
}

impl fmt::Debug for CameraLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CameraLaw").field("camera", &self.camera).finish_non_exhaustive()
    }
}
