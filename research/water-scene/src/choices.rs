//! Choices by chance, for what is decided once per clip.

use barrelman_vocab::rng::SplitMix64;

/// Choices by the next numbers of a generator.
pub(super) trait Choices {
    /// True with this probability.
    fn chance(&mut self, share: f64) -> bool;

    /// -1 or 1, with equal probability.
    fn sign(&mut self) -> f64;

    /// One of the choices, of which there must be at least one.
    fn choose<T: Copy>(&mut self, choices: &[T]) -> T;
}

impl Choices for SplitMix64 {
    fn chance(&mut self, share: f64) -> bool {
        self.uniform() < share
    }

    fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    fn choose<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.uniform() * choices.len() as f64) as usize]
    }
}
