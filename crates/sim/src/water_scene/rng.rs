//! Draws one after the other from a seed, for what is decided once per clip.

use crate::noise;

/// A stream of numbers; streams of the same seed do not depend on each other.
#[derive(Debug, Clone)]
pub(super) struct Rng {
    seed: u64,
    stream: u64,
    count: u64,
}

impl Rng {
    pub(super) const fn new(seed: u64, stream: u64) -> Self {
        Self { seed, stream, count: 0 }
    }

    /// A number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.count += 1;
        noise::unit(self.seed, self.stream, self.count)
    }

    /// A number in [low, high).
    pub(super) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True in that share of draws.
    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    /// -1 or 1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// One of these. There must be one at least.
    pub(super) fn choose<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize]
    }

    /// A number with mean 0 and variance 1: the sum of twelve uniform ones, which ends at 6.
    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}
