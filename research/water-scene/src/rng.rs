//! A sequential random generator for what is decided once per clip.

use barrelman_sim::noise;

/// A stream of random numbers: the hash of [`noise::hash`] (the finaliser of SplitMix64) over a counter. Streams of
/// the same seed are independent.
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

    /// Uniform sample in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.count += 1;
        noise::unit(self.seed, self.stream, self.count)
    }

    /// Uniform sample in [low, high).
    pub(super) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with this probability.
    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    /// -1 or 1, with equal probability.
    pub(super) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// One of the choices, of which there must be at least one.
    pub(super) fn choose<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize]
    }

    /// Approximately normal sample with mean 0 and variance 1: the sum of twelve uniform numbers, within +-6.
    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}
