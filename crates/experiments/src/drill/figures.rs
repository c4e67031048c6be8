//! The figures of a drill: the same ones for a person and for a law.

use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::measure;
use barrelman_vocab::VehicleProfile;
use schemars::JsonSchema;
use serde::Serialize;

/// How well the boat was seen, and what the camera did for it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct DrillFigures {
    /// Share of the time with the boat in the picture, 0 to 1.
    pub in_picture: f64,
    /// Share of the time with the boat in the ellipse, 0 to 1.
    pub in_ellipse: f64,
    /// Movements of the camera: commands that start from rest.
    pub moves: usize,
    /// Way of the camera: the integral of |rate| over both axes, radians.
    pub travel_rad: f64,
}

impl DrillFigures {
    /// The figures of a log.
    pub(super) fn of(log: &TrialLog, profile: &VehicleProfile) -> Self {
        let metrics = measure(log, log.region(profile.region), log.picture);
        let share = |lost_s: f64| {
            if metrics.duration_s > 0.0 { (1.0 - lost_s / metrics.duration_s).clamp(0.0, 1.0) } else { 0.0 }
        };
        let out_s = metrics.out_of_picture_s.unwrap_or_default();
        Self {
            in_picture: share(out_s),
            // Without pictures, nothing is known of where the boat is beyond the border.
            in_ellipse: share(metrics.time_outside_s.max(out_s)),
            moves: metrics.moves.unwrap_or_default(),
            travel_rad: metrics.travel_rad.unwrap_or_default(),
        }
    }
}
