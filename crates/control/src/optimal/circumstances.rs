//! The circumstances that the values of the intermittent mode are adapted to: sway, steepness of the view, and how fast the
//! target usually is.
//!
//! A fast target is brought deeper inside, and more slowly; a camera that looks down steeply starts later and stops
//! earlier, because pan hardly moves the picture there; in sway the camera starts earlier.

use super::running_mean::RunningMean;

/// The circumstances of one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circumstances {
    /// Standard deviation of the kite's sway, semi-axes of the region.
    pub(super) sway: f64,
    /// Additional turning that moves the target to the centre, relative to a level camera: 0 to 3.
    pub(super) steepness: f64,
    /// Mean of the target's bearing rate, rad/s.
    pub(super) usual_rate: f64,
}

/// A value that depends on the circumstances: `base + sway s + steepness e + usual_rate v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adapted {
    /// The value for a platform without sway, a level camera and a target at rest.
    pub base: f64,
    /// Added for each semi-axis of the sway's standard deviation.
    pub sway: f64,
    /// Added for each unit of additional turning that a steep view takes.
    pub steepness: f64,
    /// Added for each rad/s of the target's usual bearing rate.
    pub usual_rate: f64,
}

impl Adapted {
    /// The value in these circumstances.
    pub(super) fn value(&self, circumstances: &Circumstances) -> f64 {
        let Circumstances { sway, steepness, usual_rate } = *circumstances;
        self.base + self.sway * sway + self.steepness * steepness + self.usual_rate * usual_rate
    }
}

/// The longest interval between two observations that counts, seconds: in a longer one the target was not seen.
const MAX_INTERVAL_S: f64 = 0.1;
/// Time constant of the mean, seconds.
const MEMORY_S: f64 = 30.0;

/// The running mean of a target's bearing rate, rad/s.
pub(super) type UsualRate = RunningMean<1>;

/// A usual rate without observations.
pub(super) const fn usual_rate() -> UsualRate {
    RunningMean::new(MEMORY_S, MAX_INTERVAL_S)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::Timestamp;

    use super::*;

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_secs_f64(seconds)
    }

    #[test]
    fn a_value_adds_up_what_each_circumstance_adds() {
        let value = Adapted { base: 1.0, sway: -2.0, steepness: 0.5, usual_rate: 3.0 };
        let circumstances = Circumstances { sway: 0.1, steepness: 2.0, usual_rate: 0.2 };
        assert!((value.value(&circumstances) - (1.0 - 0.2 + 1.0 + 0.6)).abs() < 1e-12);
    }

    #[test]
    fn the_usual_rate_is_the_mean_of_all_rates_until_the_memory_is_full() {
        let mut usual = usual_rate();
        let rate = |k: u32| if k <= 100 { 0.1 } else { 0.3 };
        let last = (0..=200).map(|k| usual.observe([rate(k)], at(0.05 * f64::from(k)))[0]).last();
        assert!(last.is_some_and(|mean| (mean - 0.2).abs() < 1e-9), "{last:?}");
    }

    #[test]
    fn time_without_the_target_does_not_count() {
        let mut usual = usual_rate();
        for k in 0..=100_u32 {
            usual.observe([0.1], at(0.1 * f64::from(k)));
        }
        let after_a_minute = usual.observe([0.9], at(70.0))[0];
        assert!(after_a_minute < 0.11, "{after_a_minute}");
    }
}
