//! The circumstances that the values of the intermittent mode are adapted to: sway, steepness of the view,
//! how fast the target usually is, and how late and how slowly the camera answers.
//!
//! A fast target is brought deeper inside, and more slowly; a camera that looks down steeply starts later and
//! stops earlier, because pan hardly moves the picture there; in sway the camera starts earlier.

use super::running_mean::RunningMean;
use crate::camera_model::CameraModel;

/// The circumstances of one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circumstances {
    /// Standard deviation of the kite's sway, semi-axes of the region.
    pub(super) sway: f64,
    /// Additional turning that moves the target to the centre, relative to a level camera: 0 to 3.
    pub(super) steepness: f64,
    /// Mean of the target's bearing rate, rad/s.
    pub(super) usual_rate: f64,
    /// Time from a picture's capture to the effect of a command, less that of the Fotokite Pro, seconds: the
    /// mean, within the range that was examined.
    pub(super) delay_s: f64,
    /// Mean of both axes' lags, less that of the Fotokite Pro, seconds, within the range that was examined.
    pub(super) lag_s: f64,
}

/// A value that depends on the circumstances: `base + sway s + steepness e + usual_rate v + delay d + lag l`.
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
    /// Added for each second of delay beyond that of the Fotokite Pro.
    pub delay: f64,
    /// Added for each second of lag beyond that of the Fotokite Pro.
    pub lag: f64,
}

impl Adapted {
    /// The value in these circumstances.
    pub(super) fn value(&self, circumstances: &Circumstances) -> f64 {
        let Circumstances { sway, steepness, usual_rate, delay_s, lag_s } = *circumstances;
        self.base
            + self.sway * sway
            + self.steepness * steepness
            + self.usual_rate * usual_rate
            + self.delay * delay_s
            + self.lag * lag_s
    }
}

/// The longest interval between two observations that counts, seconds: in a longer one the target was not
/// seen.
const MAX_INTERVAL_S: f64 = 0.1;
/// Time constant of the mean, seconds.
const MEMORY_S: f64 = 30.0;

/// From a picture's capture to the effect of a command with a Fotokite Pro in the laboratory, seconds: the
/// video's latency, and the dead time of pan. The values without `delay` are for this delay.
const USUAL_DELAY_S: f64 = 0.3;
/// Mean of the lags of a Fotokite Pro's axes, seconds. The values without `lag` are for this lag.
const USUAL_LAG_S: f64 = 0.26;

/// The running means of a target's bearing rate, rad/s, and of the delay, seconds.
pub(super) type UsualMotion = RunningMean<2>;

/// Means without observations.
pub(super) const fn usual_motion() -> UsualMotion {
    RunningMean::new(MEMORY_S, MAX_INTERVAL_S)
}

/// Additional delays and lags that were examined, seconds: video that is 0 to 0.8 s late, and cameras from a
/// gimbal's with 0.06 s to the Fotokite Pro's. Beyond, the values stay: the stop ellipse must not outgrow the
/// start ellipse.
const ADDITIONAL_DELAYS_S: (f64, f64) = (-0.1, 0.7);
const ADDITIONAL_LAGS_S: (f64, f64) = (-0.2, 0.0);

/// A delay in seconds, less that of a Fotokite Pro.
pub(super) fn additional_delay_s(delay_s: f64) -> f64 {
    let (least, most) = ADDITIONAL_DELAYS_S;
    (delay_s - USUAL_DELAY_S).clamp(least, most)
}

/// The mean of both axes' lags in seconds, less that of a Fotokite Pro.
pub(super) fn additional_lag_s(camera: &CameraModel) -> f64 {
    let [pan, tilt] = camera.axes();
    let (least, most) = ADDITIONAL_LAGS_S;
    (0.5 * (pan.lag_s() + tilt.lag_s()) - USUAL_LAG_S).clamp(least, most)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::Timestamp;

    use super::super::intermittent_tuning::IntermittentTuning;
    use super::*;

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_secs_f64(seconds)
    }

    #[test]
    fn a_value_adds_up_what_each_circumstance_adds() {
        let value = Adapted { base: 1.0, sway: -2.0, steepness: 0.5, usual_rate: 3.0, delay: -0.5, lag: 2.0 };
        let circumstances =
            Circumstances { sway: 0.1, steepness: 2.0, usual_rate: 0.2, delay_s: 0.4, lag_s: -0.1 };
        assert!((value.value(&circumstances) - (1.0 - 0.2 + 1.0 + 0.6 - 0.2 - 0.2)).abs() < 1e-12);
    }

    #[test]
    fn the_stop_ellipse_stays_inside_the_start_ellipse_whatever_the_vehicle() {
        let tuning = IntermittentTuning::DEFAULT;
        for delay_s in [0.0, 0.2, 0.3, 1.0, 5.0].map(additional_delay_s) {
            for lag_s in [ADDITIONAL_LAGS_S.0, ADDITIONAL_LAGS_S.1] {
                let circumstances =
                    Circumstances { sway: 0.0, steepness: 0.0, usual_rate: 0.0, delay_s, lag_s };
                let (start, stop) = (tuning.start.value(&circumstances), tuning.stop.value(&circumstances));
                assert!(0.2 < stop && stop < start - 0.05, "{circumstances:?}: {stop}, {start}");
            }
        }
    }

    #[test]
    fn the_usual_rate_is_the_mean_of_all_rates_until_the_memory_is_full() {
        let mut usual = usual_motion();
        let rate = |k: u32| if k <= 100 { 0.1 } else { 0.3 };
        let last = (0..=200).map(|k| usual.observe([rate(k), 0.0], at(0.05 * f64::from(k)))[0]).last();
        assert!(last.is_some_and(|mean| (mean - 0.2).abs() < 1e-9), "{last:?}");
    }

    #[test]
    fn time_without_the_target_does_not_count() {
        let mut usual = usual_motion();
        for k in 0..=100_u32 {
            usual.observe([0.1, 0.0], at(0.1 * f64::from(k)));
        }
        let after_a_minute = usual.observe([0.9, 0.0], at(70.0))[0];
        assert!(after_a_minute < 0.11, "{after_a_minute}");
    }
}
