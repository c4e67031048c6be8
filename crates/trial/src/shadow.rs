//! What the paper's schema would have done in a trial that another law servoed.
//!
//! The rows say where the target was seen and what was commanded; with the vehicle's profile that gives the target's
//! bearing, and the schema is simulated on it. It is an estimate: the camera is imagined from its commands, and of the
//! video's latency only the profile's nominal value is known.

use barrelman_control::{CameraModel, LawInput, Percept, Region, ShadowController, ShadowStep};
use barrelman_vocab::{Timestamp, VehicleProfile};

use crate::logs::TrialLog;

/// What the schema would have seen and done, row by row; `None` where the target was not seen.
pub fn schema_over(log: &TrialLog, region: Region, profile: &VehicleProfile) -> Vec<Option<ShadowStep>> {
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
        camera.apply_command(profile.from_vehicle(row.rates.unwrap_or_default()), now);
        step
    });
    steps.collect()
}
