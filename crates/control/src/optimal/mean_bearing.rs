//! The mean direction of a target over the last minutes, to which the target is expected to return.
//!
//! A boat that works in an area turns back sooner or later, towards the middle of the area. The prediction
//! has a critically damped spring from the target to its mean direction: of an offset from the mean, the
//! share `1 − (1 + t/T) e^(−t/T)` is gone after the time t, where T is the return time. Within half a second
//! that is next to nothing; after several seconds it is most of the offset.
//!
//! Not handled: a boat that travels on and never returns. Its mean follows it, `memory_s` later.

use super::running_mean::RunningMean;
use crate::view::Direction;

/// The longest interval between two observations that counts, seconds: in a longer one the target was not
/// seen.
const MAX_INTERVAL_S: f64 = 0.2;

/// What a target is expected to return to, and how soon.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExpectedReturn {
    /// The mean direction; its length is at most 1.
    pub(super) mean: Direction,
    /// Return time T, seconds, above 0.
    pub(super) return_time_s: f64,
}

impl ExpectedReturn {
    /// The share of the offset from the mean that is gone after a duration, 0 to 1.
    pub(super) fn share_after(&self, duration_s: f64) -> f64 {
        let times = duration_s / self.return_time_s;
        1.0 - (1.0 + times) * libm::exp(-times)
    }
}

/// The running mean of a target's directions.
pub(super) type MeanBearing = RunningMean<3>;

/// A mean direction without observations; `memory_s` is the time constant of its weights, seconds.
pub(super) const fn mean_bearing(memory_s: f64) -> MeanBearing {
    RunningMean::new(memory_s, MAX_INTERVAL_S)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::Timestamp;

    use super::*;

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_secs_f64(seconds)
    }

    #[test]
    fn the_mean_is_that_of_all_directions_until_the_memory_is_full() {
        let mut mean = mean_bearing(20.0);
        let mut last = [0.0; 3];
        for k in 0..=100_u32 {
            let direction = if k <= 50 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
            last = mean.observe(direction, at(0.1 * f64::from(k)));
        }
        assert!((last[0] - 0.5).abs() < 1e-9 && (last[1] - 0.5).abs() < 1e-9, "{last:?}");
    }

    #[test]
    fn the_mean_follows_a_target_that_travels_on() {
        let mut mean = mean_bearing(20.0);
        mean.observe([0.0, 1.0, 0.0], at(0.0));
        let last = (1..=1200).map(|k| mean.observe([1.0, 0.0, 0.0], at(0.1 * f64::from(k)))).last();
        assert!(last.is_some_and(|mean| mean[0] > 0.99), "{last:?}");
    }

    #[test]
    fn time_without_the_target_does_not_count() {
        let mut mean = mean_bearing(20.0);
        for k in 0..=100_u32 {
            mean.observe([0.0, 1.0, 0.0], at(0.1 * f64::from(k)));
        }
        let after_a_minute = mean.observe([1.0, 0.0, 0.0], at(70.0));
        assert!(after_a_minute[0] < 0.03, "{after_a_minute:?}");
    }

    #[test]
    fn hardly_anything_returns_within_half_a_second_and_most_of_it_within_three_return_times() {
        let expected = ExpectedReturn { mean: [0.0, 1.0, 0.0], return_time_s: 3.0 };
        assert!(expected.share_after(0.0) == 0.0 && expected.share_after(0.5) < 0.02);
        assert!((0.75..0.85).contains(&expected.share_after(9.0)));
    }
}
