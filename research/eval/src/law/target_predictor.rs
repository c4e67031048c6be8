//! The prediction that the reference laws work on: the same bearing filter and camera model as the optimal
//! law's, so that the table compares laws and not estimators.

use core::time::Duration;

use barrelman_control::optimal::Tuning;
use barrelman_control::view::View;
use barrelman_control::{Bearing, BearingFilter, BearingNoise, CameraModel, LawInput};
use barrelman_vocab::ImagePoint;

/// The noise model of the target's motion.
const NOISE: BearingNoise = Tuning::MINIMUM_ENERGY.noise;

/// How long the target's rate keeps its value, seconds.
pub(super) const RATE_MEMORY_S: f64 = NOISE.rate_time_constant_s;

/// The least lag of an axis that the reference laws compute with, seconds.
pub(super) const MIN_LAG_S: f64 = 0.02;

/// Predicts target and camera from the observations so far.
#[derive(Debug, Clone)]
pub(super) struct TargetPredictor(BearingFilter);

/// Target and camera at the time from which a command given now has an effect on both axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictedState {
    focal_px: f64,
    /// The target's bearing when it was last measured.
    bearing: Bearing,
    /// How long before the predicted time it was measured.
    age_s: f64,
    filter: BearingFilter,
    /// Pan and tilt, radians.
    angles: [f64; 2],
    /// Rates of pan and tilt, rad/s.
    pub(super) rates: [f64; 2],
}

impl TargetPredictor {
    pub(super) const fn new() -> Self {
        Self(BearingFilter::new(NOISE))
    }

    /// Forgets the target.
    pub(super) fn reset_target(&mut self) {
        self.0.reset_target();
    }

    /// Takes in a measurement and predicts; `None` where the target was never measured.
    pub(super) fn update(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> Option<PredictedState> {
        self.0.observe(input, camera);
        let dynamics = camera.dynamics();
        let focal_px = camera.focal_px(input.captured, input.picture);
        let (measured_at, bearing) = self.0.estimate()?;
        let dead_time = dynamics.pan.start_dead_time.max(dynamics.tilt.start_dead_time);
        let effective_at = input.now.plus(dead_time);
        let (pan, tilt) = camera.angles_at(effective_at);
        let (pan_rate, tilt_rate) = camera.rates_at(effective_at);
        let age: Duration = effective_at.since(*measured_at);
        Some(PredictedState {
            focal_px,
            bearing: *bearing,
            age_s: age.as_secs_f64(),
            filter: self.0,
            angles: [pan, tilt],
            rates: [pan_rate, tilt_rate],
        })
    }
}

impl PredictedState {
    /// The view, and the target's position in it, `after_s` later, when the camera has turned by these angles
    /// of pan and tilt, radians.
    pub(super) fn project(&self, after_s: f64, turned: [f64; 2]) -> (View, ImagePoint) {
        let view = View::new(self.focal_px, self.angles[0] + turned[0], self.angles[1] + turned[1]);
        (view, view.project(self.filter.predict(&self.bearing, self.age_s + after_s).apparent_direction()))
    }
}
