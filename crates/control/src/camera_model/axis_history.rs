//! The state of an axis, and its recent history.

use crate::ring::Ring;

/// Number of stored states of each axis. At [`MIN_STATE_INTERVAL_S`] they cover 2 s, less the start dead
/// time.
const HISTORY_LEN: usize = 256;
/// Shortest interval between two stored states, seconds.
const MIN_STATE_INTERVAL_S: f64 = 0.008;

/// Angle and rate of an axis at a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub(super) at_s: f64,
    pub(super) angle: f64,
    pub(super) rate: f64,
}

impl State {
    /// The state `duration_s` later under a constant commanded rate.
    pub(super) fn after(self, duration_s: f64, commanded: f64, lag_s: f64) -> Self {
        if commanded == 0.0 && self.rate == 0.0 {
            return Self { at_s: self.at_s + duration_s, ..self };
        }
        let decay = libm::exp(-duration_s / lag_s);
        let excess = self.rate - commanded;
        Self {
            at_s: self.at_s + duration_s,
            angle: self.angle + commanded * duration_s + excess * lag_s * (1.0 - decay),
            rate: commanded + excess * decay,
        }
    }
}

/// The recent states of an axis.
#[derive(Debug, Clone)]
pub(super) struct AxisHistory(Ring<State, HISTORY_LEN>);

impl AxisHistory {
    /// A history of an axis that always rested at this angle.
    pub(super) fn new(angle: f64) -> Self {
        Self(Ring::new(State { at_s: f64::NEG_INFINITY, angle, rate: 0.0 }))
    }

    pub(super) fn push(&mut self, state: State) {
        self.0.push(state, |previous, newest| newest.at_s - previous.at_s >= MIN_STATE_INTERVAL_S);
    }

    /// The interpolated state at a time; the oldest stored state for earlier times.
    pub(super) fn at(&self, at_s: f64) -> State {
        let mut later = self.0.newest();
        for earlier in self.0.earlier() {
            if earlier.at_s <= at_s {
                return interpolate(*earlier, *later, at_s);
            }
            later = earlier;
        }
        *later
    }

    /// Adds an offset to all angles.
    pub(super) fn shift(&mut self, by: f64) {
        self.0.for_each_mut(|state| state.angle += by);
    }
}

/// Interpolates two states: the angle by the cubic that matches both angles and rates, the rate linearly.
fn interpolate(earlier: State, later: State, at_s: f64) -> State {
    let span_s = later.at_s - earlier.at_s;
    if !span_s.is_finite() || span_s <= 0.0 {
        return State { at_s, rate: 0.0, ..earlier };
    }
    let t = ((at_s - earlier.at_s) / span_s).clamp(0.0, 1.0);
    let rise = later.angle - earlier.angle;
    let (bend, twist) = (earlier.rate * span_s - rise, rise - later.rate * span_s);
    let angle = earlier.angle + t * rise + t * (1.0 - t) * ((1.0 - t) * bend + t * twist);
    State { at_s, angle, rate: earlier.rate + t * (later.rate - earlier.rate) }
}
