//! A camera that zooms in and out, in trials without pixels.

use crate::tick::TICK_S;

/// A zoom that goes on for the whole trial: the logarithm of the focal length swings like a cosine, from the scenario's focal
/// length to a multiple of it and back. The renderer does not zoom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zoom {
    /// The largest focal length over the scenario's, above 0.
    pub ratio: f64,
    /// From one time at the scenario's focal length to the next, seconds, above 0.
    pub period_s: f64,
}

impl Zoom {
    /// The focal length at a tick over the scenario's.
    pub fn factor_at(&self, tick: u64) -> f64 {
        let phase = core::f64::consts::TAU * (tick as f64 * TICK_S) / self.period_s;
        libm::pow(self.ratio, 0.5 * (1.0 - libm::cos(phase)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tick::TICKS_PER_SECOND;

    #[test]
    fn a_zoom_goes_to_its_ratio_and_back_within_a_period() {
        let zoom = Zoom { ratio: 2.0, period_s: 20.0 };
        for (at_s, expected) in [(0, 1.0), (5, core::f64::consts::SQRT_2), (10, 2.0), (20, 1.0)] {
            let factor = zoom.factor_at(at_s * u64::from(TICKS_PER_SECOND));
            assert!((factor - expected).abs() < 1e-9, "{at_s} s: {factor}");
        }
    }
}
