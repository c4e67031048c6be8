//! The receding-horizon modes: the rates are computed anew at each step, with the least energy.
//!
//! The law predicts the target's position at the time at which a command takes effect ([`BearingFilter`],
//! [`CameraModel`]). While the predicted position stays well inside the region, the camera rests. When it
//! leaves the *start* ellipse within the look-ahead, the camera starts. From then on, each step computes the
//! constant rates that move the target into the *aim* ellipse within the horizon with the least `∫|u|² dt`
//! ([`Transfer`]). When a camera told to rest now would keep the target inside the *stop* ellipse, the camera
//! is told to rest. `docs/optimal-law.md` derives the law and shows the ellipses.
//!
//! Work per step: O(1), no allocation.

use barrelman_vocab::profile::{AxisRates, VehicleProfile};
use barrelman_vocab::{AngularRate, CameraCommand, Framed, Timestamp};

use super::framing::Framing;
use super::prediction::{MIN_RATE_TO_STOP, PredictedView, Prediction, TransferGoal};
use super::tuning::Tuning;
use crate::bearing::{BearingFilter, Propagation};
use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::transfer::{Pair, Transfer};

/// A target already inside the aim ellipse is moved to this share of the stop ellipse.
const RECENTRING_SHARE: f64 = 0.8;

/// The optimal law in one of its receding-horizon modes, with its state.
#[derive(Debug, Clone)]
pub struct RecedingHorizonLaw {
    tuning: Tuning,
    limits: Pair,
    min_rates: Pair,
    bearings: BearingFilter,
    framing: Framing,
    stop_look_ahead: Propagation,
    command_in_force: CameraCommand,
    rested_since: Option<Timestamp>,
}

impl RecedingHorizonLaw {
    /// A law without observations.
    pub fn new(tuning: Tuning, framed: Framed, profile: &VehicleProfile) -> Self {
        let AxisRates { pan, tilt } = profile.limits;
        let limits = [pan, tilt].map(AngularRate::radians_per_second);
        let min_rates =
            [&profile.camera.pan, &profile.camera.tilt].map(|axis| axis.min_rate.radians_per_second());
        Self {
            limits: [0, 1].map(|axis| limits[axis].min(tuning.max_rate.max(min_rates[axis]))),
            min_rates,
            bearings: BearingFilter::new(tuning.noise),
            framing: Framing::new(framed),
            stop_look_ahead: Propagation::new(tuning.stop_look_ahead_s, &tuning.noise),
            tuning,
            command_in_force: CameraCommand::REST,
            rested_since: None,
        }
    }

    /// Discards the observations of the target.
    pub fn reset_target(&mut self) {
        self.bearings.reset_target();
    }

    /// Notes that `command` is in force from `now` on.
    pub fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        if command.is_rest() && !self.command_in_force.is_rest() {
            self.rested_since = Some(now);
        }
        self.command_in_force = command;
    }

    /// Computes the command of one step.
    pub fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        let noise = self.tuning.noise;
        let Some(prediction) = Prediction::observed(&mut self.bearings, noise, input, camera) else {
            return CameraCommand::REST;
        };
        let prediction = prediction.held_in(self.framing.region(input));
        let outside = if self.command_in_force.is_rest() {
            self.view_outside_start(&prediction, input.now)
        } else {
            self.view_outside_stop(&prediction)
        };
        outside.map_or(CameraCommand::REST, |predicted| self.rates(&prediction, &predicted))
    }

    /// The stop ellipse for a target of this slowness (0: fast, 1: stationary).
    fn stop_ellipse(&self, slowness: f64) -> f64 {
        self.tuning.stop + self.tuning.slow_target_widening * slowness
    }

    /// The bearing rate relative to that of a fast target: 0 (stationary) to 1 (fast).
    fn relative_speed(&self, prediction: &Prediction<'_>) -> f64 {
        (prediction.bearing.angular_speed() / self.tuning.fast_target_rate).min(1.0)
    }

    /// The first predicted view of a resting camera in which the target is outside of the start ellipse.
    fn view_outside_start(&self, prediction: &Prediction<'_>, now: Timestamp) -> Option<PredictedView> {
        let has_rested =
            self.rested_since.is_none_or(|since| now.since(since).as_secs_f64() >= self.tuning.min_rest_s);
        if !has_rested {
            return None;
        }
        let look_ahead_s = self.relative_speed(prediction) * self.tuning.start_look_ahead_s;
        let half = Propagation::new(0.5 * look_ahead_s, &self.tuning.noise);
        [Propagation::ZERO, half, half.then(&half)].iter().map(|after| prediction.view_at_rest(after)).find(
            |resting| {
                let start =
                    self.tuning.start + self.tuning.start_sigma * prediction.position_std_dev(resting);
                prediction.region.p(resting.point) > start * start
            },
        )
    }

    /// The predicted view of a camera that is told to rest now, if the target is outside of the stop ellipse.
    fn view_outside_stop(&self, prediction: &Prediction<'_>) -> Option<PredictedView> {
        let resting = prediction.view_at_rest(&self.stop_look_ahead);
        let stop = self.stop_ellipse(1.0 - self.relative_speed(prediction));
        (prediction.region.p(resting.point) > stop * stop).then_some(resting)
    }

    /// The command of a moving camera. `resting` is the predicted view of a camera that rests instead.
    fn rates(&self, prediction: &Prediction<'_>, resting: &PredictedView) -> CameraCommand {
        let slowness = 1.0 - self.relative_speed(prediction);
        let steepness = 1.0 + self.tuning.steep_view_gain * (prediction.turning_effort(resting) - 1.0);
        let horizon_s = (1.0 + self.tuning.slow_target_gain * slowness) * steepness * self.tuning.horizon_s;
        let aim = self.tuning.aim + self.tuning.slow_target_widening * slowness;
        let transfer = prediction.transfer(&TransferGoal { horizon_s, look_ahead_s: 0.0, aim }, self.limits);
        let mut wanted = transfer.solve().rates;
        let mut fastest = wanted[0].abs().max(wanted[1].abs());
        if fastest == 0.0 {
            // The target reaches the aim ellipse without any motion, but stays outside of the stop ellipse:
            // move slowly.
            let aim = RECENTRING_SHARE * self.stop_ellipse(slowness);
            let factor = horizon_s / (steepness * steepness * self.tuning.recentring_time_s);
            let recentring = Transfer { aim, ..transfer }.solve();
            wanted = recentring.rates.map(|rate| factor * rate);
            fastest = wanted[0].abs().max(wanted[1].abs());
            if fastest == 0.0 {
                // Either the target arrives without any motion, or no allowed rate brings it closer.
                return if recentring.reaches_aim { self.command_in_force } else { CameraCommand::REST };
            }
        }
        self.limited(wanted, fastest, &transfer)
    }

    /// The wanted rates as a command: scaled to the smallest rate, within the limits of the transfer, and
    /// with the deadband. `fastest` is the larger of both absolute rates, above 0.
    fn limited(&self, wanted: Pair, fastest: f64, transfer: &Transfer) -> CameraCommand {
        let faster = usize::from(wanted[1].abs() > wanted[0].abs());
        let scale = (self.tuning.min_rate.max(self.min_rates[faster]) / fastest).max(1.0);
        let in_force = self.command_in_force;
        let before = [in_force.pan, in_force.tilt].map(AngularRate::radians_per_second);
        let mut rates = [0.0; 2];
        for axis in [0, 1] {
            let rate = wanted[axis] * scale;
            let share = wanted[axis].abs() / fastest;
            let (min, max) = (transfer.min_rates[axis], transfer.max_rates[axis]);
            let limit = if rate < 0.0 { -min } else { max };
            rates[axis] =
                if share < self.tuning.min_axis_share || limit < MIN_RATE_TO_STOP.max(self.min_rates[axis]) {
                    0.0
                } else {
                    snap_to_min_rate(rate, self.min_rates[axis]).clamp(min, max)
                };
        }
        let has_changed =
            (0..2).any(|axis| (rates[axis] - before[axis]).abs() >= self.tuning.command_deadband);
        if !has_changed && !in_force.is_rest() {
            return in_force;
        }
        let [pan, tilt] = rates.map(AngularRate::from_radians_per_second);
        CameraCommand::turning(pan, tilt)
    }
}

/// The nearest rate that the vehicle can turn at: 0 below half of the smallest rate.
fn snap_to_min_rate(rate: f64, min_rate: f64) -> f64 {
    if rate.abs() >= min_rate {
        rate
    } else if rate.abs() >= 0.5 * min_rate {
        libm::copysign(min_rate, rate)
    } else {
        0.0
    }
}
