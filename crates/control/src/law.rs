//! The camera law of a pilot, together with its camera model.

use core::fmt;

use barrelman_vocab::{
    Angle, CameraCommand, Framed, LawId, LawName, MotionPrior, PictureSize, Timestamp, VehicleProfile,
};

use crate::camera_model::CameraModel;
use crate::centring::{Centring, CentringGains};
use crate::law_input::LawInput;
use crate::motor_schema::MotorSchema;
use crate::optimal::{OptimalLaw, OptimalSettings};

/// Computes camera commands from percepts.
pub trait Law: Send {
    /// Computes the command of one step.
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand;

    /// Notes that `command` is in force from `now` on: the law's own command, or what the safety rule made of
    /// it.
    fn on_command_applied(&mut self, _command: CameraCommand, _now: Timestamp) {}

    /// Discards the observations of the target: another target was selected.
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

/// The choice of a law, with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LawSettings {
    /// The paper's motor schema.
    #[default]
    MotorSchema,
    /// A PID controller that centres the target.
    Centring(CentringGains),
    /// The optimal law: both axes at once with the least energy.
    Optimal(OptimalSettings),
}

impl LawSettings {
    /// A law with its default settings.
    pub fn new(law: LawId) -> Self {
        match law.name() {
            LawName::Schema => Self::MotorSchema,
            LawName::Centre => Self::Centring(CentringGains::HAND_TUNED),
            LawName::Optimal => Self::Optimal(OptimalSettings::new(law.mode().unwrap_or_default())),
        }
    }

    /// The same law, which shows this if it is the optimal law.
    #[must_use]
    pub const fn showing(self, framed: Framed) -> Self {
        match self {
            Self::MotorSchema | Self::Centring(_) => self,
            Self::Optimal(settings) => Self::Optimal(OptimalSettings { framed, ..settings }),
        }
    }

    /// What the law shows.
    pub const fn framed(&self) -> Framed {
        match self {
            Self::MotorSchema | Self::Centring(_) => Framed::Boat,
            Self::Optimal(settings) => settings.framed,
        }
    }

    /// The law.
    pub const fn id(&self) -> LawId {
        match self {
            Self::MotorSchema => LawId::Schema,
            Self::Centring(_) => LawId::Centre,
            Self::Optimal(settings) => LawId::new(LawName::Optimal, settings.mode),
        }
    }
}

/// A law with its camera model.
pub struct CameraLaw {
    camera: CameraModel,
    law: Box<dyn Law>,
}

impl CameraLaw {
    /// The chosen law for a vehicle.
    pub fn new(settings: LawSettings, profile: &VehicleProfile) -> Self {
        let law: Box<dyn Law> = match settings {
            LawSettings::MotorSchema => Box::new(MotorSchema::new(profile.motor_schema_rates)),
            LawSettings::Centring(gains) => Box::new(Centring::new(gains, profile.limits)),
            LawSettings::Optimal(settings) => Box::new(OptimalLaw::new(&settings, profile)),
        };
        Self::from_law(law, profile)
    }

    /// A custom law for a vehicle.
    pub fn from_law(law: Box<dyn Law>, profile: &VehicleProfile) -> Self {
        Self { camera: CameraModel::of(profile), law }
    }

    /// Changes the law. The camera model keeps its state.
    pub fn change_law(&mut self, settings: LawSettings, profile: &VehicleProfile) {
        self.law = Self::new(settings, profile).law;
    }

    /// The camera model.
    pub const fn camera(&self) -> &CameraModel {
        &self.camera
    }

    /// Advances the camera model to `now`.
    pub fn advance_to(&mut self, now: Timestamp) {
        self.camera.advance_to(now);
    }

    /// Computes the command of one step.
    pub fn command(&mut self, input: &LawInput<'_>) -> CameraCommand {
        self.camera.advance_to(input.now);
        self.law.command(input, &self.camera)
    }

    /// Predicted shift of the picture between two times of capture due to camera motion.
    pub fn motion_prior(&self, from: Timestamp, to: Timestamp, picture: PictureSize) -> MotionPrior {
        self.camera.motion_prior(from, to, picture)
    }

    /// Notes that `command` is in force from `now` on, whatever its origin.
    pub fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        self.camera.apply_command(command, now);
        self.law.on_command_applied(command, now);
    }

    /// Processes a report of the camera's tilt at the time `at`.
    pub fn on_tilt_report(&mut self, tilt: Angle, at: Timestamp) {
        self.camera.correct_tilt(tilt, at);
    }

    /// Processes the first report of the camera's tilt, at the time `at`: it takes the place of the
    /// profile's.
    pub fn on_first_tilt_report(&mut self, tilt: Angle, at: Timestamp) {
        self.camera.set_tilt(tilt, at);
    }

    /// Processes a report of the horizontal field of view at the time `at`.
    pub fn on_field_of_view_report(&mut self, angle: Angle, at: Timestamp) {
        self.camera.set_field_of_view(angle, at);
    }

    /// The pictures are those of another video from `at` on ([`CameraModel::change_video`]).
    pub fn on_other_video(&mut self, field_of_view: Option<Angle>, at: Timestamp) {
        self.camera.change_video(field_of_view, at);
    }

    /// Processes the growth of the picture between two times of capture, the logarithm of its scale.
    pub fn on_growth(&mut self, growth: f64, from: Timestamp, to: Timestamp) {
        self.camera.on_growth(growth, from, to);
    }

    /// Discards the observations of the target: another target was selected.
    pub fn reset_target(&mut self) {
        self.law.reset_target();
    }
}

impl fmt::Debug for CameraLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CameraLaw").field("camera", &self.camera).finish_non_exhaustive()
    }
}
