//! The model of one axis: dead time, first-order lag, rate limit and end stops.

use barrelman_vocab::profile::AxisDynamics;

use super::axis_history::{AxisHistory, State};

/// Smallest lag, seconds; shorter lags are replaced by it to avoid a division by zero.
const MIN_LAG_S: f64 = 1e-3;
/// A decaying rate below this becomes zero, rad/s.
const MIN_RATE: f64 = 1e-9;

/// One axis.
#[derive(Debug, Clone)]
pub(crate) struct AxisModel {
    start_s: f64,
    /// At least `start_s`.
    stop_s: f64,
    lag_s: f64,
    limit: f64,
    stops: Option<(f64, f64)>,
    /// The state at the time of the last step + `start_s`.
    state: State,
    /// The commanded rate that has taken effect.
    rate_in_effect: f64,
    /// Time at which a pending zero command takes effect.
    zero_at_s: Option<f64>,
    history: AxisHistory,
}

impl AxisModel {
    /// An axis at rest. `limit` is the largest rate in rad/s, `stops` the lower and upper end stop in
    /// radians.
    pub(super) fn new(dynamics: AxisDynamics, limit: f64, angle: f64, stops: Option<(f64, f64)>) -> Self {
        Self {
            start_s: dynamics.start_dead_time.as_secs_f64(),
            stop_s: dynamics.stop_dead_time.max(dynamics.start_dead_time).as_secs_f64(),
            lag_s: dynamics.lag.as_secs_f64().max(MIN_LAG_S),
            limit,
            stops,
            state: State { at_s: dynamics.start_dead_time.as_secs_f64(), angle, rate: 0.0 },
            rate_in_effect: 0.0,
            zero_at_s: None,
            history: AxisHistory::new(angle),
        }
    }

    pub(crate) const fn lag_s(&self) -> f64 {
        self.lag_s
    }

    /// The largest rate.
    pub(super) const fn limit(&self) -> f64 {
        self.limit
    }

    pub(crate) const fn start_s(&self) -> f64 {
        self.start_s
    }

    /// The time for which an axis goes on at its full rate when it is told to rest as soon as it has started,
    /// seconds.
    pub(crate) fn stopping_s(&self) -> f64 {
        self.stop_s - self.start_s + self.lag_s
    }

    /// The factor by which a rate decays within this duration.
    pub(crate) fn rate_decay(&self, duration_s: f64) -> f64 {
        libm::exp(-duration_s / self.lag_s)
    }

    /// The angle after the rate of the current state has decayed by this factor, without any further command.
    pub(crate) fn angle_coasting(&self, decay: f64) -> f64 {
        self.clamp_to_stops(self.state.angle + self.state.rate * self.lag_s * (1.0 - decay))
    }

    /// Distances from an angle to the lower and the upper end stop, radians; `None` without end stops.
    pub(crate) fn range_to_stops(&self, angle: f64) -> Option<(f64, f64)> {
        self.stops.map(|(low, high)| ((angle - low).max(0.0), (high - angle).max(0.0)))
    }

    fn clamp_to_stops(&self, angle: f64) -> f64 {
        self.stops.map_or(angle, |(low, high)| angle.clamp(low, high))
    }

    /// The angle `duration_s` after the current state's time if the axis is told to rest now.
    pub(crate) fn angle_if_rested(&self, duration_s: f64) -> f64 {
        self.clamp_to_stops(self.unclamped_angle_if_rested(duration_s))
    }

    fn unclamped_angle_if_rested(&self, duration_s: f64) -> f64 {
        let state = self.state;
        if self.rate_in_effect == 0.0 && state.rate == 0.0 {
            return state.angle;
        }
        if self.rate_in_effect == 0.0 {
            return self.angle_coasting(self.rate_decay(duration_s));
        }
        let zero_s = self.zero_at_s.map_or(self.stop_s - self.start_s, |at_s| at_s - state.at_s);
        if duration_s <= zero_s {
            return state.after(duration_s, self.rate_in_effect, self.lag_s).angle;
        }
        let at_zero = state.after(zero_s, self.rate_in_effect, self.lag_s);
        at_zero.after(duration_s - zero_s, 0.0, self.lag_s).angle
    }

    /// Applies a commanded rate from `now_s` on. NaN counts as zero.
    pub(super) fn command(&mut self, rate: f64, now_s: f64) {
        self.advance(now_s + self.start_s);
        let rate = if rate.is_nan() { 0.0 } else { rate.clamp(-self.limit, self.limit) };
        if rate != 0.0 {
            (self.rate_in_effect, self.zero_at_s) = (rate, None);
        } else if self.rate_in_effect != 0.0 && self.zero_at_s.is_none() {
            self.zero_at_s = Some(now_s + self.stop_s);
            self.advance(now_s + self.start_s);
        }
    }

    /// Advances the state to a time; an earlier time changes nothing.
    pub(super) fn advance(&mut self, until_s: f64) {
        if let Some(zero_s) = self.zero_at_s.filter(|zero_s| *zero_s <= until_s) {
            self.integrate_to(zero_s);
            (self.rate_in_effect, self.zero_at_s) = (0.0, None);
        }
        self.integrate_to(until_s);
    }

    fn integrate_to(&mut self, until_s: f64) {
        let duration_s = until_s - self.state.at_s;
        if duration_s > 0.0 {
            self.state = self.integrated(self.state, until_s, self.rate_in_effect);
            self.history.push(self.state);
        }
    }

    /// The state at a later time under a constant commanded rate. An end stop ends the motion.
    fn integrated(&self, state: State, until_s: f64, commanded: f64) -> State {
        let mut state = state.after(until_s - state.at_s, commanded, self.lag_s);
        if commanded == 0.0 && state.rate.abs() < MIN_RATE {
            state.rate = 0.0;
        }
        let clamped = self.clamp_to_stops(state.angle);
        if clamped.to_bits() != state.angle.to_bits() {
            (state.angle, state.rate) = (clamped, 0.0);
        }
        state
    }

    /// The state at a time; the oldest stored state for times before the history.
    pub(super) fn at(&self, at_s: f64) -> State {
        if at_s < self.state.at_s {
            return self.history.at(at_s);
        }
        match self.zero_at_s.filter(|zero_s| *zero_s <= at_s) {
            Some(zero_s) => {
                self.integrated(self.integrated(self.state, zero_s, self.rate_in_effect), at_s, 0.0)
            }
            None => self.integrated(self.state, at_s, self.rate_in_effect),
        }
    }

    /// Sets other end stops.
    pub(super) fn set_stops(&mut self, stops: (f64, f64)) {
        self.stops = Some(stops);
    }

    /// Adds an offset to the angle and its history, as far as the end stops allow.
    pub(super) fn shift(&mut self, by: f64) {
        let angle = self.clamp_to_stops(self.state.angle + by);
        let by = angle - self.state.angle;
        self.state.angle = angle;
        self.history.shift(by);
    }
}
