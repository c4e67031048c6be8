//! The camera as a law imagines it: where it pointed when a picture was taken, and where the commands that are under
//! way will have taken it.
//!
//! Each axis answers a command after a dead time, through a first-order lag: `w' = (u - w)/lag`, `angle' = w`. The
//! dead time of a zero may be longer than that of a command that moves, as it is on the recorded vehicle; a later
//! command overrules an earlier one that has not taken effect by then. So the state that is kept is the one at *now +
//! the start's dead time*: every command so far is in it but for one zero that may still be on its way (the predictor
//! of Smith, 1957). What a picture shows is looked up by its time of capture in the states of the past, so that no
//! count of frames and no latency of the video enters.
//!
//! It knows commands alone. Where the vehicle reports the gimbal's attitude, [`CameraModel::correct_tilt`] pulls the
//! tilt towards it; where it focal_lengths, [`CameraModel::set_field_of_view`] says so. The sway of the kite is not in it.
//! O(1), no allocation.

use core::time::Duration;

use barrelman_vocab::profile::{AxisDynamics, AxisRates, CameraDynamics};
use barrelman_vocab::{Angle, CameraCommand, ImagePoint, MotionPrior, PictureSize, Timestamp};

use crate::ring::Ring;
use crate::view::View;

/// States that are remembered of each axis; at [`MIN_STATE_INTERVAL_S`] they reach back by 2 s, less the start's dead time.
const HISTORY_LEN: usize = 256;
/// States closer together than this are not remembered apart, seconds.
const MIN_STATE_INTERVAL_S: f64 = 0.008;
/// Lags shorter than this are taken for this, seconds: no division by zero.
const MIN_LAG_S: f64 = 1e-3;
/// A rate below this is none, rad/s: it would fade for ever.
const MIN_RATE: f64 = 1e-9;
/// How a kite sways in wind between pictures, radians for each root of a second: by 3 degrees, forgotten after 2 s.
const SWAY_RAD_PER_ROOT_S: f64 = 0.05;
/// What share of a shift by the axes may be wrong: dead times and lags differ by so much.
const SHIFT_ERROR: f64 = 0.5;
/// What share of its error a report of the tilt takes away.
const REPORT_SHARE: f64 = 0.2;

/// Focal lengths that a camera may have, as shares of the picture's width.
const FOCAL_SHARES: core::ops::RangeInclusive<f64> = 0.1..=20.0;
/// Focal lengths that differ by less than this share are the same: a report is rounded.
const MIN_FOCAL_CHANGE: f64 = 0.002;
/// Focal lengths that are remembered; at [`MIN_FOCAL_INTERVAL`] they reach back by 1.2 s of a zoom under way.
const FOCAL_HISTORY_LEN: usize = 32;
/// Focal lengths reported closer together than this are not remembered apart.
const MIN_FOCAL_INTERVAL: Duration = Duration::from_millis(40);

/// The camera with both axes.
#[derive(Debug, Clone)]
pub struct CameraModel {
    dynamics: CameraDynamics,
    pan: AxisModel,
    tilt: AxisModel,
    focal_lengths: FocalHistory,
}

impl CameraModel {
    /// A camera at rest, with its tilt as the profile has it where nothing else tells.
    pub fn new(dynamics: CameraDynamics, limits: AxisRates) -> Self {
        let axis = |dynamics: AxisDynamics, limit: f64, angle: f64, stops| AxisModel {
            start_s: dynamics.start_dead_time.as_secs_f64(),
            stop_s: dynamics.stop_dead_time.max(dynamics.start_dead_time).as_secs_f64(),
            lag_s: dynamics.lag.as_secs_f64().max(MIN_LAG_S),
            limit,
            stops,
            state: State { at_s: dynamics.start_dead_time.as_secs_f64(), angle, rate: 0.0 },
            in_effect: 0.0,
            zero_at_s: None,
            history: StateHistory::new(angle),
        };
        let (low, high) = dynamics.tilt_stops;
        let tilt = dynamics.initial_tilt.radians().clamp(low.radians(), high.radians());
        Self {
            pan: axis(dynamics.pan, limits.pan.radians_per_second(), 0.0, None),
            tilt: axis(
                dynamics.tilt,
                limits.tilt.radians_per_second(),
                tilt,
                Some((low.radians(), high.radians())),
            ),
            focal_lengths: FocalHistory::new(dynamics.focal_share),
            dynamics,
        }
    }

    /// What it was made of.
    pub const fn dynamics(&self) -> &CameraDynamics {
        &self.dynamics
    }

    /// Nothing else was commanded until `now`.
    pub fn advance_to(&mut self, now: Timestamp) {
        let now_s = now.as_secs_f64();
        for axis in [&mut self.pan, &mut self.tilt] {
            axis.advance(now_s + axis.start_s);
        }
    }

    /// A command is in force from `now` on.
    pub fn apply_command(&mut self, command: CameraCommand, now: Timestamp) {
        let now_s = now.as_secs_f64();
        self.pan.command(command.pan.radians_per_second(), now_s);
        self.tilt.command(command.tilt.radians_per_second(), now_s);
    }

    /// The gimbal reported its tilt at `at`.
    pub fn correct_tilt(&mut self, tilt: Angle, at: Timestamp) {
        let error = tilt.radians() - self.tilt.at(at.as_secs_f64()).angle;
        if error.is_finite() {
            self.tilt.shift(REPORT_SHARE * error);
        }
    }

    /// From `at` on the picture shows so much from its left edge to its right: the camera focal_lengths. What no lens shows is not
    /// believed.
    pub fn set_field_of_view(&mut self, angle: Angle, at: Timestamp) {
        let seen = angle.radians();
        let share = 0.5 / libm::tan(0.5 * seen);
        let known = self.focal_lengths.at(at);
        let is_one = seen > 0.0 && seen < core::f64::consts::PI && FOCAL_SHARES.contains(&share);
        if is_one && (share - known).abs() > MIN_FOCAL_CHANGE * known {
            self.focal_lengths.push(share, at);
        }
    }

    /// The focal length of a picture of that size that was taken at a time, pixels.
    pub fn focal_px(&self, at: Timestamp, picture: PictureSize) -> f64 {
        self.focal_lengths.at(at) * f64::from(picture.width)
    }

    /// Where the camera pointed at a time, which may lie 1.5 s back: pan (from where it first pointed; unbounded)
    /// and tilt, radians.
    pub fn angles_at(&self, at: Timestamp) -> (f64, f64) {
        let at_s = at.as_secs_f64();
        (self.pan.at(at_s).angle, self.tilt.at(at_s).angle)
    }

    /// How a resting thing in the picture's middle shifted between two pictures, because the axes turned. How well that
    /// is known: the kite's own sway is not in it, nor what a vehicle does otherwise than its profile says.
    pub fn motion_prior(&self, from: Timestamp, to: Timestamp, picture: PictureSize) -> MotionPrior {
        let focal_px = self.focal_px(to, picture);
        let interval = to.since(from);
        if self.focal_px(from, picture).to_bits() != focal_px.to_bits() {
            // Everything moved, each thing otherwise.
            let std_dev_px = f64::from(picture.width);
            return MotionPrior { shift_u_px: 0.0, shift_v_px: 0.0, std_dev_px, interval };
        }
        let ((pan, tilt), (pan_then, tilt_then)) = (self.angles_at(to), self.angles_at(from));
        let middle = View::new(focal_px, pan_then, tilt_then).unproject(ImagePoint { x: 0.0, y: 0.0 });
        let shift = View::new(focal_px, pan, tilt).project(middle);
        let sway = focal_px * SWAY_RAD_PER_ROOT_S * libm::sqrt(interval.as_secs_f64());
        MotionPrior {
            shift_u_px: shift.x,
            shift_v_px: -shift.y,
            std_dev_px: libm::hypot(sway, SHIFT_ERROR * libm::hypot(shift.x, shift.y)),
            interval,
        }
    }

    /// How fast it turned at a time, pan and tilt, rad/s; what is on its way is in it.
    pub fn rates_at(&self, at: Timestamp) -> (f64, f64) {
        let at_s = at.as_secs_f64();
        (self.pan.at(at_s).rate, self.tilt.at(at_s).rate)
    }

    pub(crate) const fn axes(&self) -> [&AxisModel; 2] {
        [&self.pan, &self.tilt]
    }
}

/// Angle and rate of an axis at a time.
#[derive(Debug, Clone, Copy)]
struct State {
    at_s: f64,
    angle: f64,
    rate: f64,
}

impl State {
    /// The state `duration_s` later under a constant rate asked for.
    fn after(self, duration_s: f64, asked: f64, lag_s: f64) -> Self {
        if asked == 0.0 && self.rate == 0.0 {
            return Self { at_s: self.at_s + duration_s, ..self };
        }
        let kept = libm::exp(-duration_s / lag_s);
        let excess = self.rate - asked;
        Self {
            at_s: self.at_s + duration_s,
            angle: self.angle + asked * duration_s + excess * lag_s * (1.0 - kept),
            rate: asked + excess * kept,
        }
    }
}

/// One axis.
#[derive(Debug, Clone)]
pub(crate) struct AxisModel {
    start_s: f64,
    /// At least `start_s`.
    stop_s: f64,
    lag_s: f64,
    limit: f64,
    stops: Option<(f64, f64)>,
    /// As of the last step's time + `start_s`.
    state: State,
    in_effect: f64,
    /// When a zero on its way takes effect.
    zero_at_s: Option<f64>,
    history: StateHistory,
}

impl AxisModel {
    pub(crate) const fn lag_s(&self) -> f64 {
        self.lag_s
    }

    pub(crate) const fn start_s(&self) -> f64 {
        self.start_s
    }

    /// What is left of a rate after that span.
    pub(crate) fn rate_decay(&self, duration_s: f64) -> f64 {
        libm::exp(-duration_s / self.lag_s)
    }

    /// The angle once that is left of the rate at that time, if nothing is asked of the axis from then on.
    pub(crate) fn angle_coasting(&self, left: f64) -> f64 {
        self.clamp_to_stops(self.state.angle + self.state.rate * self.lag_s * (1.0 - left))
    }

    /// How far it is from an angle to the end stops, down and up, radians; `None` where it turns freely.
    pub(crate) fn range_to_stops(&self, angle: f64) -> Option<(f64, f64)> {
        self.stops.map(|(low, high)| ((angle - low).max(0.0), (high - angle).max(0.0)))
    }

    /// An angle, or the end stop before it.
    fn clamp_to_stops(&self, angle: f64) -> f64 {
        self.stops.map_or(angle, |(low, high)| angle.clamp(low, high))
    }

    /// The angle `duration_s` after that time if the axis is told now to rest.
    pub(crate) fn angle_if_rested(&self, duration_s: f64) -> f64 {
        self.clamp_to_stops(self.angle_going_to_rest(duration_s))
    }

    fn angle_going_to_rest(&self, duration_s: f64) -> f64 {
        let state = self.state;
        if self.in_effect == 0.0 && state.rate == 0.0 {
            return state.angle;
        }
        if self.in_effect == 0.0 {
            return self.angle_coasting(self.rate_decay(duration_s));
        }
        let zero_s = self.zero_at_s.map_or(self.stop_s - self.start_s, |at_s| at_s - state.at_s);
        if duration_s <= zero_s {
            return state.after(duration_s, self.in_effect, self.lag_s).angle;
        }
        let at_zero = state.after(zero_s, self.in_effect, self.lag_s);
        at_zero.after(duration_s - zero_s, 0.0, self.lag_s).angle
    }

    fn command(&mut self, asked: f64, now_s: f64) {
        self.advance(now_s + self.start_s);
        let asked = if asked.is_nan() { 0.0 } else { asked.clamp(-self.limit, self.limit) };
        if asked != 0.0 {
            (self.in_effect, self.zero_at_s) = (asked, None);
        } else if self.in_effect != 0.0 && self.zero_at_s.is_none() {
            self.zero_at_s = Some(now_s + self.stop_s);
            self.advance(now_s + self.start_s);
        }
    }

    /// Carries the state on to a time; one that lies back changes nothing.
    fn advance(&mut self, until_s: f64) {
        if let Some(zero_s) = self.zero_at_s.filter(|zero_s| *zero_s <= until_s) {
            self.integrate_to(zero_s);
            (self.in_effect, self.zero_at_s) = (0.0, None);
        }
        self.integrate_to(until_s);
    }

    fn integrate_to(&mut self, until_s: f64) {
        let duration_s = until_s - self.state.at_s;
        if duration_s > 0.0 {
            self.state = self.turned(self.state, until_s, self.in_effect);
            self.history.push(self.state);
        }
    }

    /// A state at a later time, under a constant rate asked for; an end stop ends the motion.
    fn turned(&self, state: State, until_s: f64, asked: f64) -> State {
        let mut state = state.after(until_s - state.at_s, asked, self.lag_s);
        if asked == 0.0 && state.rate.abs() < MIN_RATE {
            state.rate = 0.0;
        }
        let held = self.clamp_to_stops(state.angle);
        if held.to_bits() != state.angle.to_bits() {
            (state.angle, state.rate) = (held, 0.0);
        }
        state
    }

    /// Where it was at a time; before everything that is remembered, as the oldest.
    fn at(&self, at_s: f64) -> State {
        if at_s < self.state.at_s {
            return self.history.at(at_s);
        }
        match self.zero_at_s.filter(|zero_s| *zero_s <= at_s) {
            Some(zero_s) => self.turned(self.turned(self.state, zero_s, self.in_effect), at_s, 0.0),
            None => self.turned(self.state, at_s, self.in_effect),
        }
    }

    fn shift(&mut self, by: f64) {
        let kept = self.clamp_to_stops(self.state.angle + by);
        let by = kept - self.state.angle;
        self.state.angle = kept;
        self.history.shift(by);
    }
}

/// Focal lengths as shares of the picture's width, each with the time from which on it is so.
#[derive(Debug, Clone)]
struct FocalHistory(Ring<(f64, Timestamp), FOCAL_HISTORY_LEN>);

impl FocalHistory {
    fn new(share: f64) -> Self {
        Self(Ring::new((share, Timestamp::ZERO)))
    }

    /// A report; one that is older than the last changes nothing.
    fn push(&mut self, share: f64, at: Timestamp) {
        let (_, last) = *self.0.newest();
        if at >= last {
            self.0.push((share, at), |(_, before), (_, last)| last.since(*before) >= MIN_FOCAL_INTERVAL);
        }
    }

    /// The share at a time; before everything that is remembered, the oldest.
    fn at(&self, at: Timestamp) -> f64 {
        let (mut share, mut since) = *self.0.newest();
        for (earlier_share, earlier) in self.0.earlier() {
            if since <= at {
                break;
            }
            (share, since) = (*earlier_share, *earlier);
        }
        share
    }
}

/// The states of the past.
#[derive(Debug, Clone)]
struct StateHistory(Ring<State, HISTORY_LEN>);

impl StateHistory {
    fn new(angle: f64) -> Self {
        Self(Ring::new(State { at_s: f64::NEG_INFINITY, angle, rate: 0.0 }))
    }

    fn push(&mut self, state: State) {
        self.0.push(state, |before, newest| newest.at_s - before.at_s >= MIN_STATE_INTERVAL_S);
    }

    fn at(&self, at_s: f64) -> State {
        let mut later = self.0.newest();
        for earlier in self.0.earlier() {
            if earlier.at_s <= at_s {
                return interpolate(*earlier, *later, at_s);
            }
            later = earlier;
        }
        *later
    }

    fn shift(&mut self, by: f64) {
        self.0.for_each_mut(|state| state.angle += by);
    }
}

/// Between two states: the angle by the cubic that has both rates.
fn interpolate(earlier: State, later: State, at_s: f64) -> State {
    let duration_s = later.at_s - earlier.at_s;
    if !duration_s.is_finite() || duration_s <= 0.0 {
        return State { at_s, rate: 0.0, ..earlier };
    }
    let t = ((at_s - earlier.at_s) / duration_s).clamp(0.0, 1.0);
    let rise = later.angle - earlier.angle;
    let (bend, twist) = (earlier.rate * duration_s - rise, rise - later.rate * duration_s);
    let angle = earlier.angle + t * rise + t * (1.0 - t) * ((1.0 - t) * bend + t * twist);
    State { at_s, angle, rate: earlier.rate + t * (later.rate - earlier.rate) }
}
