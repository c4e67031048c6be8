//! What the reference laws predict from: the same bearing filter and camera model that the optimal law has, so that the
//! table compares laws and not estimators.

use core::time::Duration;

use barrelman_control::optimal::Tuning;
use barrelman_control::view::View;
use barrelman_control::{Bearing, BearingFilter, CameraModel, LawInput};
use barrelman_vocab::ImagePoint;

/// How the target is taken to move.
const NOISE: barrelman_control::BearingNoise = Tuning::MINIMUM_ENERGY.noise;

/// The filter with what it has seen.
#[derive(Debug, Clone)]
pub(super) struct Outlook(BearingFilter);

/// Target and camera at the time from which a command given now counts on both axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ahead {
    focal_px: f64,
    /// The target as it was last seen, how long before that time, and what knows how it goes on.
    bearing: Bearing,
    age_s: f64,
    filter: BearingFilter,
    /// Pan and tilt, radians, and how fast they turn, rad/s.
    pub(super) angles: [f64; 2],
    pub(super) rates: [f64; 2],
}

impl Outlook {
    pub(super) const fn new() -> Self {
        Self(BearingFilter::new(NOISE))
    }

    pub(super) fn reset_target(&mut self) {
        self.0.reset_target();
    }

    /// Takes the look, and predicts.
    pub(super) fn look(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> Option<Ahead> {
        self.0.observe(input, camera);
        let dynamics = camera.dynamics();
        let focal_px = camera.focal_px(input.captured, input.picture);
        let (looked, bearing) = self.0.estimate()?;
        let dead_time = dynamics.pan.start_dead_time.max(dynamics.tilt.start_dead_time);
        let counts = input.now.plus(dead_time);
        let (pan, tilt) = camera.angles_at(counts);
        let (pan_rate, tilt_rate) = camera.rates_at(counts);
        let age: Duration = counts.since(*looked);
        Some(Ahead {
            focal_px,
            bearing: *bearing,
            age_s: age.as_secs_f64(),
            filter: self.0,
            angles: [pan, tilt],
            rates: [pan_rate, tilt_rate],
        })
    }
}

impl Ahead {
    /// The target's rate keeps its value for about so long, seconds.
    pub(super) const MEMORY_S: f64 = NOISE.rate_time_constant_s;

    /// The view and where the target is in it after so long, with the camera turned by these angles until then.
    pub(super) fn seen(&self, after_s: f64, turned: [f64; 2]) -> (View, ImagePoint) {
        let view = View::new(self.focal_px, self.angles[0] + turned[0], self.angles[1] + turned[1]);
        (view, view.project(self.filter.predict(&self.bearing, self.age_s + after_s).apparent_direction()))
    }
}
