//! How fast the picture turns while the camera rests: the sway of the UAV in the wind.
//!
//! With the turn d of the picture between two frames, radians, and their interval t, the mean square of the
//! rate d / t is averaged over the rests, the newest [`MEMORY_S`] counting most. The sway of a kite lasts for
//! seconds, so that the rate, not the shift from frame to frame, tells what a motion of some tenths of a
//! second has to be compared with.

use core::time::Duration;

/// Time constant of the average, seconds of rest.
const MEMORY_S: f64 = 20.0;
/// Rest that must have been seen before the sway is known, seconds: a sway to and fro.
const LEAST_REST_S: f64 = 2.0;

/// The sway of the picture of a camera at rest.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SwayEstimate {
    mean_square: f64,
    rest_s: f64,
}

impl SwayEstimate {
    /// The picture turned by these angles, radians, within `interval`, above zero, while the camera rested.
    pub(crate) fn add(&mut self, [right, down]: [f64; 2], interval: Duration) {
        let interval_s = interval.as_secs_f64();
        let square = (right * right + down * down) / (interval_s * interval_s);
        if !square.is_finite() {
            return;
        }
        self.rest_s += interval_s;
        // The plain mean of the first rests, then an exponential average.
        let weight = interval_s / self.rest_s.min(MEMORY_S);
        self.mean_square += weight.min(1.0) * (square - self.mean_square);
    }

    /// Root mean square of the rate, rad/s; `None`: the camera has not rested for long enough.
    pub(crate) fn rate_rad_per_s(&self) -> Option<f64> {
        (self.rest_s >= LEAST_REST_S).then(|| self.mean_square.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_known_after_some_rest_and_follows_the_wind() {
        let mut sway = SwayEstimate::default();
        let frame = Duration::from_millis(40);
        for index in 0..50 {
            assert_eq!(sway.rate_rad_per_s(), None, "{index}");
            sway.add([0.0004, 0.0], frame);
        }
        let calm = sway.rate_rad_per_s().unwrap();
        assert!((calm - 0.01).abs() < 1e-9, "{calm}");
        for _ in 0..1_000 {
            sway.add([0.0, -0.008], frame);
        }
        let windy = sway.rate_rad_per_s().unwrap();
        assert!((0.17..0.2).contains(&windy), "{windy}");
        sway.add([f64::NAN, 0.0], frame);
        assert_eq!(sway.rate_rad_per_s(), Some(windy));
    }
}
