//! The smallest value of a series, forgotten no faster than a quartz drifts.

use std::time::Duration;

use barrelman_vocab::time::Timestamp;

/// Largest difference of the rates of two clocks, parts in a million: quartz clocks are specified with 20 to
/// 100 ppm.
const MAX_DRIFT_PPM: i128 = 200;

/// The smallest value of a series of clock differences. It rises by [`MAX_DRIFT_PPM`] of the time that
/// passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Baseline {
    value_ns: i128,
    at: Timestamp,
}

impl Baseline {
    pub(super) const fn new(value_ns: i128, at: Timestamp) -> Self {
        Self { value_ns, at }
    }

    /// The baseline at a later time.
    pub(super) fn at(&self, now: Timestamp) -> i128 {
        self.value_ns + nanos(now.since(self.at)) * MAX_DRIFT_PPM / 1_000_000
    }

    /// Takes a value. Returns how much it lies above the baseline: 0 or more.
    pub(super) fn observe(&mut self, value_ns: i128, now: Timestamp) -> i128 {
        let baseline_ns = self.at(now);
        if value_ns <= baseline_ns {
            *self = Self::new(value_ns, now);
        }
        (value_ns - baseline_ns).max(0)
    }
}

/// A duration in nanoseconds.
pub(super) fn nanos(duration: Duration) -> i128 {
    i128::try_from(duration.as_nanos()).unwrap_or(i128::MAX)
}
