//! Simulation of the paper's motor schema on the target bearings of a trial in which another law moved the camera.
//!
//! The bearings follow from the positions and commands of the log and the vehicle's profile. The result is an estimate:
//! the camera's motion is modelled from its commands, and the video latency is the profile's nominal value.

use barrelman_control::{CameraModel, LawInput, Percept, Region, ShadowController, ShadowStep};
use barrelman_vocab::{Timestamp, VehicleProfile};

use crate::logs::TrialLog;

/// P and command as the motor schema would have had them, row by row; `None` where the log has no position.
pub fn simulate_motor_schema(
    log: &TrialLog,
    region: Region,
    profile: &VehicleProfile,
) -> Vec<Option<ShadowStep>> {
    let mut camera = CameraModel::new(profile.camera, profile.limits);
    let mut shadow = ShadowController::new(profile);
    let steps = log.rows.iter().map(|row| {
        let now = Timestamp::from_secs_f64(row.time_s);
        let step = row.position.map(|position| {
            let percept = Percept::new(position, region);
            let captured = now.minus(profile.video_latency);
            shadow.step(
                &LawInput { percept: &percept, region, picture: log.frame, captured, is_measured: true, now },
                &camera,
            )
        });
        camera.apply_command(row.command.unwrap_or_default(), now);
        step
    });
    steps.collect()
}
