//! The course of one axis over one movement: a ramp up to a plateau, and a ramp down to rest.
//!
//! An axis with a short lag would start and stop with a jerk; ramps give it the response time of the slower
//! axis. The total variation of a course whose plateau is not corrected is twice the plateau, the least that
//! it can be.

/// The ramps of one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ramps {
    /// Largest increase of the rate, rad/s².
    rise: f64,
    /// Largest decrease of the rate, rad/s².
    fall: f64,
    min_rate: f64,
}

impl Ramps {
    /// Ramps after which the axis responds like one of these lags, in seconds: the mean delay of a ramp is
    /// half of its duration.
    pub(super) fn new(lag_s: f64, rate: f64, (start_s, stop_s): (f64, f64), min_rate: f64) -> Self {
        // Without a ramp the slope is the largest number that may be multiplied by an interval of zero.
        let slope = |response_s: f64| (rate / (2.0 * (response_s - lag_s)).max(0.0)).min(f64::MAX);
        Self { rise: slope(start_s), fall: slope(stop_s), min_rate }
    }

    /// The next rate on the way from the rate in force to the goal, `interval_s` after the last one.
    pub(super) fn next(&self, before: f64, goal: f64, interval_s: f64) -> f64 {
        if before * goal < 0.0 {
            return self.next(before, 0.0, interval_s);
        }
        let (from, to) = (before.abs(), goal.abs());
        let sign = if goal == 0.0 { before } else { goal };
        let size = if to > from {
            (from + self.rise * interval_s).max(self.min_rate).min(to)
        } else {
            (from - self.fall * interval_s).max(to)
        };
        let is_too_slow = size < self.min_rate && to < self.min_rate;
        // Zero has one sign: recordings are compared bit for bit.
        if is_too_slow || size == 0.0 { 0.0 } else { libm::copysign(size, sign) }
    }
}
