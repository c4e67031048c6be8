//! The running mean of what was observed of a target: of all observations at first, with exponential weights
//! once the mean extends over the memory.
//!
//! Work per observation: O(1), no allocation.

use barrelman_vocab::Timestamp;

/// The running mean of N numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunningMean<const N: usize> {
    /// Time constant of the weights, seconds.
    memory_s: f64,
    /// The longest interval between two observations that counts, seconds: in a longer one the target was not
    /// seen.
    max_interval_s: f64,
    /// Time of the newest observation, and the mean.
    mean: Option<(Timestamp, [f64; N])>,
    /// The duration over which the mean extends, seconds: at most `memory_s`.
    averaged_s: f64,
}

impl<const N: usize> RunningMean<N> {
    /// A mean without observations.
    pub(super) const fn new(memory_s: f64, max_interval_s: f64) -> Self {
        Self { memory_s, max_interval_s, mean: None, averaged_s: 0.0 }
    }

    /// Takes in an observation at a time, and returns the mean.
    pub(super) fn observe(&mut self, observed: [f64; N], at: Timestamp) -> [f64; N] {
        let (last, before) = self.mean.unwrap_or((at, observed));
        let interval_s = at.since(last).as_secs_f64().min(self.max_interval_s);
        self.averaged_s = (self.averaged_s + interval_s).min(self.memory_s);
        let share = if self.averaged_s > 0.0 { interval_s / self.averaged_s } else { 0.0 };
        let mean = core::array::from_fn(|i| before[i] + share * (observed[i] - before[i]));
        self.mean = Some((at, mean));
        mean
    }
}
