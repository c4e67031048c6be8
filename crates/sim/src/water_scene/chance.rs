//! Draws one after the other from a seed, for what is decided once per clip.

use crate::noise;

/// A stream of numbers; streams of the same seed do not depend on each other.
#[derive(Debug, Clone)]
pub(super) struct Chance {
    seed: u64,
    stream: u64,
    drawn: u64,
}

impl Chance {
    pub(super) const fn new(seed: u64, stream: u64) -> Self {
        Self { seed, stream, drawn: 0 }
    }

    /// A number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.drawn += 1;
        noise::unit(self.seed, self.stream, self.drawn)
    }

    /// A number in [low, high).
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True in that share of draws.
    pub(super) fn happens(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    /// -1 or 1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }

    /// One of these. There must be one at least.
    pub(super) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize]
    }

    /// A number with mean 0 and variance 1: the sum of twelve uniform ones, which ends at 6.
    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}
