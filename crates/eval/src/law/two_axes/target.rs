//! The target's motion in both axes.
//!
//! Azimuth and elevation follow two independent Ornstein-Uhlenbeck rates along the horizontal and upwards; the azimuth's is
//! divided by the cosine of the elevation. With c the decay of the rates in a step, T their time constant and n normal
//! deviates: `v' = c v + s n`, `bearing' = bearing + T (1 − c) v`. So that pan and tilt keep their meaning, the path turns
//! back at an elevation of [`MAX_ELEVATION`]; no law and no policy knows that.

use barrelman_sim::tick::{TICK_S, TICKS_PER_SECOND};

use super::super::axis_model::{FOCAL_PX, RATE_STD_DEV, RATE_TIME_CONSTANT_S, REGION};
use super::super::model_figures::TRIAL_S;
use crate::rng::Rng;

/// The largest elevation of a path, up or down, radians.
const MAX_ELEVATION: f64 = 0.6;
/// The least cosine of the elevation that divides the azimuth's rate.
const MIN_COS_ELEVATION: f64 = 0.5;
/// Depths below this share of the distance count as behind the camera, and the ellipse's radius there.
const MIN_DEPTH: f64 = 0.05;
const RADIUS_BEHIND: f64 = 20.0;

/// A target: azimuth and elevation, radians, and the rates to the right and upwards, rad/s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    pub(super) bearing: [f64; 2],
    pub(super) rates: [f64; 2],
}

/// A step of the target's motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct TargetStep {
    decay: f64,
    /// Standard deviation of the new part of a rate, rad/s.
    spread: f64,
}

impl TargetStep {
    pub(super) fn of_duration(duration_s: f64) -> Self {
        let decay = (-duration_s / RATE_TIME_CONSTANT_S).exp();
        Self { decay, spread: RATE_STD_DEV * (1.0 - decay * decay).sqrt() }
    }
}

impl Target {
    /// The target after a step with these normal deviates.
    pub(super) fn after(&self, step: TargetStep, deviates: [f64; 2]) -> Self {
        let bearing = self.bearing_after(RATE_TIME_CONSTANT_S * (1.0 - step.decay));
        let rates = [0, 1].map(|axis| step.decay * self.rates[axis] + step.spread * deviates[axis]);
        Self { bearing, rates }
    }

    /// The expected bearing after the time in which a rate of 1 rad/s turns the target by `reach_s` radians
    /// ([`reach_s`]).
    pub(super) fn bearing_after(&self, reach_s: f64) -> [f64; 2] {
        let [azimuth, elevation] = self.bearing;
        let [right, up] = self.rates;
        [azimuth + reach_s * right / elevation.cos().max(MIN_COS_ELEVATION), elevation + reach_s * up]
    }
}

/// How far a rate of 1 rad/s is expected to turn the target within a duration, seconds.
pub(super) fn reach_s(duration_s: f64) -> f64 {
    RATE_TIME_CONSTANT_S * (1.0 - (-duration_s / RATE_TIME_CONSTANT_S).exp())
}

/// Sines and cosines of a bearing's elevation, with its azimuth: what a projection needs of the target.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenBearing {
    azimuth: f64,
    sin: f64,
    cos: f64,
}

impl SeenBearing {
    pub(super) fn of([azimuth, elevation]: [f64; 2]) -> Self {
        let (sin, cos) = elevation.sin_cos();
        Self { azimuth, sin, cos }
    }

    /// The place in the picture of a camera with this pan and tilt, in focal lengths: right and up; `None` behind the camera.
    pub(super) fn in_picture(&self, [pan, tilt]: [f64; 2]) -> Option<[f64; 2]> {
        let (sin_pan, cos_pan) = (self.azimuth - pan).sin_cos();
        let (sin_tilt, cos_tilt) = tilt.sin_cos();
        let ahead = self.cos * cos_pan;
        let depth = ahead * cos_tilt + self.sin * sin_tilt;
        (depth > MIN_DEPTH)
            .then(|| [self.cos * sin_pan / depth, (self.sin * cos_tilt - ahead * sin_tilt) / depth])
    }

    /// The radius in the picture, in shares of the region's ellipse: 1 at its edge (the root of P).
    pub(super) fn radius(&self, pointing: [f64; 2]) -> f64 {
        self.in_picture(pointing)
            .map_or(RADIUS_BEHIND, |[x, y]| (x * FOCAL_PX / REGION.a_px).hypot(y * FOCAL_PX / REGION.b_px))
    }
}

/// A target's path: its state at each tick of a trial.
#[derive(Debug, Clone)]
pub(super) struct TargetPath(Vec<Target>);

impl TargetPath {
    /// The path of a seed.
    pub(super) fn of_seed(seed: u64) -> Self {
        let mut rng = Rng::from_name("two axes", seed);
        let mut deviates = || [rng.approximately_normal(), rng.approximately_normal()];
        let step = TargetStep::of_duration(TICK_S);
        let mut target = Target { bearing: [0.0; 2], rates: deviates().map(|n| RATE_STD_DEV * n) };
        let ticks = (TRIAL_S * f64::from(TICKS_PER_SECOND)) as usize;
        let states = (0..ticks).map(|_| {
            let now = target;
            target = now.after(step, deviates());
            let elevation = &mut target.bearing[1];
            if elevation.abs() > MAX_ELEVATION {
                *elevation = 2.0 * MAX_ELEVATION * elevation.signum() - *elevation;
                target.rates[1] = -target.rates[1];
            }
            now
        });
        Self(states.collect())
    }

    /// The state at a tick; after the end of the trial, the last.
    pub(super) fn at(&self, tick: usize) -> Target {
        self.0[tick.min(self.0.len() - 1)]
    }

    pub(super) fn ticks(&self) -> usize {
        self.0.len()
    }
}

#[cfg(test)]
mod tests {
    use barrelman_control::view::View;
    use barrelman_vocab::ImagePoint;

    use super::*;

    #[test]
    fn a_path_keeps_its_rates_and_its_elevation() {
        let paths: Vec<TargetPath> = (0..20).map(TargetPath::of_seed).collect();
        let states = || paths.iter().flat_map(|path| &path.0);
        assert!(states().all(|state| state.bearing[1].abs() <= MAX_ELEVATION));
        for axis in 0..2 {
            let squares = states().map(|state| state.rates[axis].powi(2)).sum::<f64>();
            // 20 trials have some 600 independent rates: the standard error is 3 %.
            let std_dev = (squares / states().count() as f64).sqrt();
            assert!((std_dev / RATE_STD_DEV - 1.0).abs() < 0.1, "{std_dev}");
        }
    }

    #[test]
    fn a_target_is_seen_where_the_camera_law_expects_it() {
        for (bearing, pointing) in [([0.3, -0.2], [0.1, 0.1]), ([-1.2, 0.5], [-0.9, 0.2])] {
            let [x, y] = SeenBearing::of(bearing).in_picture(pointing).unwrap();
            let place = ImagePoint { x: FOCAL_PX * x, y: FOCAL_PX * y };
            let direction = View::new(FOCAL_PX, pointing[0], pointing[1]).unproject(place);
            let [azimuth, elevation] = bearing;
            let expected =
                [azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin()];
            for (found, expected) in direction.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{bearing:?}: {direction:?}");
            }
            assert!((SeenBearing::of(bearing).radius(pointing).powi(2) - REGION.p(place)).abs() < 1e-9);
        }
    }
}
