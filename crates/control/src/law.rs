//! The camera law that a pilot works by, with the camera as it imagines it.

use core::fmt;

use barrelman_vocab::{Angle, CameraCommand, MotionPrior, PictureSize, Timestamp, VehicleProfile};

use crate::camera_model::CameraModel;
use crate::centring::{Centring, CentringGains};
use crate::optimal::{OptimalLaw, OptimalSettings};
use crate::percept::Percept;
use crate::region::Region;
use crate::schema::MotorSchema;

/// What a law works on at one step.
#[derive(Debug, Clone, Copy)]
pub struct Sight<'a> {
    /// What was seen.
    pub percept: &'a Percept,
    /// The region that the target may roam in.
    pub region: Region,
    /// The picture that it was seen in.
    pub picture: PictureSize,
    /// When that was taken.
    pub captured: Timestamp,
    /// Whether the target was seen in it; otherwise the percept is what the tracker expects.
    pub seen: bool,
    /// When the command will be in force: now.
    pub now: Timestamp,
}

/// Turns what is seen into what is asked of the camera.
pub trait Law: Send {
    /// What to ask of the camera for what is seen.
    fn command(&mut self, sight: &Sight<'_>, camera: &CameraModel) -> CameraCommand;

    /// This command is in force from `now` on: what the law asked for, or what safety made of it.
    fn in_force(&mut self, _command: CameraCommand, _now: Timestamp) {}

    /// Forgets what was seen of a target: another one was selected.
    fn forget(&mut self) {}
}

impl Law for MotorSchema {
    fn command(&mut self, sight: &Sight<'_>, _: &CameraModel) -> CameraCommand {
        Self::command(self, sight.percept)
    }
}

impl Law for Centring {
    fn command(&mut self, sight: &Sight<'_>, _: &CameraModel) -> CameraCommand {
        Self::command(self, sight.percept, sight.picture, sight.captured)
    }

    fn forget(&mut self) {
        Self::forget(self);
    }
}

impl Law for OptimalLaw {
    fn command(&mut self, sight: &Sight<'_>, camera: &CameraModel) -> CameraCommand {
        Self::command(self, sight, camera)
    }

    fn in_force(&mut self, command: CameraCommand, now: Timestamp) {
        Self::in_force(self, command, now);
    }

    fn forget(&mut self) {
        Self::forget(self);
    }
}

/// Which law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LawSettings {
    /// The paper's motor schema.
    #[default]
    Schema,
    /// A PID on the picture's centre.
    Centre(CentringGains),
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
            LawSettings::Schema => Box::new(MotorSchema::new(profile.schema)),
            LawSettings::Centre(gains) => Box::new(Centring::new(gains, profile.limits)),
            LawSettings::Optimal(settings) => Box::new(OptimalLaw::new(&settings, profile)),
        };
        Self::of(law, profile)
    }

    /// A law of one's own for a vehicle.
    pub fn of(law: Box<dyn Law>, profile: &VehicleProfile) -> Self {
        Self { camera: CameraModel::new(profile.camera, profile.limits), law }
    }

    /// What to ask of the camera for what is seen.
    pub fn command(&mut self, sight: &Sight<'_>) -> CameraCommand {
        self.camera.advance_to(sight.now);
        self.law.command(sight, &self.camera)
    }

    /// How the picture shifted between two times of capture because the camera turned.
    pub fn shift(&self, from: Timestamp, to: Timestamp, picture: PictureSize) -> MotionPrior {
        self.camera.shift(from, to, picture)
    }

    /// This command is in force from `now` on, whoever wanted it.
    pub fn in_force(&mut self, command: CameraCommand, now: Timestamp) {
        self.camera.command(command, now);
        self.law.in_force(command, now);
    }

    /// The gimbal reported the camera's tilt, as it was at `at`.
    pub fn tilt_reported(&mut self, tilt: Angle, at: Timestamp) {
        self.camera.tilt_reported(tilt, at);
    }

    /// The camera reported that its picture shows so much from the left edge to the right, from `at` on: it zooms.
    pub fn field_of_view_reported(&mut self, angle: Angle, at: Timestamp) {
        self.camera.field_of_view_reported(angle, at);
    }

    /// Forgets what was seen of a target: another one was selected.
    pub fn forget(&mut self) {
        self.law.forget();
    }
}

impl fmt::Debug for CameraLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CameraLaw").field("camera", &self.camera).finish_non_exhaustive()
    }
}
