//! Simulation of the paper's motor schema on the target bearings of a trial, or beside a run, in which
//! another law moves the camera.
//!
//! The bearings follow from the positions and commands of the log and the vehicle's profile. The result is an
//! estimate: the camera's motion is modelled from its commands, and the video latency is the profile's
//! nominal value.

use barrelman_control::{CameraModel, LawInput, Percept, Region, ShadowController, ShadowStep};
use barrelman_vocab::{CameraCommand, Timestamp, VehicleProfile};

use crate::logs::TrialLog;
use crate::work_step::WorkStep;

/// P and command as the motor schema would have had them, row by row; `None` where the log has no position.
pub fn simulate_motor_schema(
    log: &TrialLog,
    region: Region,
    profile: &VehicleProfile,
) -> Vec<Option<ShadowStep>> {
    let mut camera = CameraModel::of(profile);
    let mut shadow = ShadowController::new(profile);
    let steps = log.rows.iter().map(|row| {
        let now = Timestamp::from_secs_f64(row.time_s);
        let step = row.position.map(|position| {
            let percept = Percept::new(position, region);
            let captured = now.minus(profile.video_latency);
            shadow.step(&LawInput::measured(&percept, region, log.frame, captured, now), &camera)
        });
        camera.apply_command(row.command.unwrap_or_default(), now);
        step
    });
    steps.collect()
}

/// The motor schema with a model of the camera that it would have moved.
#[derive(Debug)]
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
            camera: CameraModel::of(profile),
            shadow: ShadowController::new(profile),
            last_captured: None,
            p: None,
            command: CameraCommand::REST,
        }
    }

    /// Follows a step of the drive. A step without a new localisation only updates the command in force.
    pub fn step(&mut self, step: &WorkStep<'_>) {
        let now = step.at;
        match (step.track.localisation(), step.percept, step.region) {
            (Some(seen), Some(percept), Some(region)) if self.last_captured != Some(seen.captured) => {
                self.last_captured = Some(seen.captured);
                let (picture, captured) = (seen.picture, seen.captured);
                let input = LawInput::measured(&percept, region, picture, captured, now);
                let ShadowStep { p, command, .. } = self.shadow.step(&input, &self.camera);
                (self.p, self.command) = (Some(p), command);
            }
            (Some(_), Some(_), Some(_)) => {}
            _ => (self.p, self.command) = (None, CameraCommand::REST),
        }
        self.camera.apply_command(step.command, now);
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
