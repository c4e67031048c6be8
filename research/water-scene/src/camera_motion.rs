//! Sway and zoom of the camera of a clip.

use barrelman_vocab::rng::SplitMix64;

use super::script::SceneKind;

/// Hull length over picture height from which on the zoom only shrinks the boat, and up to which it only
/// enlarges it.
const MIN_SHRINKING_SHARE: f64 = 0.15;
const MAX_GROWING_SHARE: f64 = 0.05;

/// Offset of the boat in the picture by the camera's sway: the sum of two sinusoids per axis.
#[derive(Debug, Clone)]
pub(super) struct Sway {
    /// Amplitude (px), angular frequency (rad/s) and phase (rad): two for the horizontal, two for the
    /// vertical.
    parts: [[f64; 3]; 4],
}

impl Sway {
    /// Amplitudes up to `reach` (horizontal, vertical), px; the speed of each sinusoid up to `max_speed`,
    /// px/s.
    pub(super) fn new(rng: &mut SplitMix64, reach: (f64, f64), max_speed: f64) -> Self {
        let mut part = |reach: f64| {
            let rate = core::f64::consts::TAU * rng.between(0.1, 0.5);
            [reach.min(max_speed / rate), rate, rng.between(0.0, core::f64::consts::TAU)]
        };
        Self { parts: [part(0.7 * reach.0), part(0.3 * reach.0), part(0.7 * reach.1), part(0.3 * reach.1)] }
    }

    pub(super) fn at(&self, time_s: f64) -> (f64, f64) {
        let [a, b, c, d] = self.parts.map(|[reach, rate, phase]| reach * libm::sin(rate * time_s + phase));
        (a + b, c + d)
    }
}

/// Zoom over time: 1 in the first frame; its logarithm is a slow sinusoid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Zoom {
    reach: f64,
    rate: f64,
    phase: f64,
}

impl Zoom {
    pub(super) fn new(rng: &mut SplitMix64, kind: SceneKind, hull_over_height: f64) -> Self {
        let factor = if kind == SceneKind::Manoeuvre { rng.between(1.5, 2.0) } else { rng.between(1.0, 1.2) };
        // A hull that fills much of the picture may only shrink; one of few pixels may only grow.
        let phase = if hull_over_height > MIN_SHRINKING_SHARE {
            core::f64::consts::FRAC_PI_2
        } else if hull_over_height < MAX_GROWING_SHARE {
            -core::f64::consts::FRAC_PI_2
        } else {
            rng.between(0.0, core::f64::consts::TAU)
        };
        let rate = core::f64::consts::TAU / rng.between(14.0, 36.0);
        Self { reach: 0.5 * libm::log(factor), rate, phase }
    }

    pub(super) fn at(self, time_s: f64) -> f64 {
        libm::exp(self.reach * (libm::sin(self.rate * time_s + self.phase) - libm::sin(self.phase)))
    }

    pub(super) fn max_zoom(self) -> f64 {
        libm::exp(self.reach * (1.0 - libm::sin(self.phase)))
    }
}
