//! The intermittent mode: one movement for each excursion.
//!
//! A resting camera waits until the predicted target leaves the start ellipse. Then one movement brings the
//! target to where it will stay inside: both axes start together, rise once to their plateaus, and fall once.
//! A plateau is corrected only where the course keeps that shape. The camera stops as soon as a camera that
//! is told to rest now would still have the target inside the stop ellipse some time later.
//! `docs/optimal-law.md` derives the law.
//!
//! Work per step: O(1), no allocation.

use barrelman_vocab::profile::{AxisRates, VehicleProfile};
use barrelman_vocab::{AngularRate, CameraCommand, Framed, Timestamp};

use super::circumstances::{Circumstances, UsualMotion, additional_delay_s, additional_lag_s, usual_motion};
use super::framing::Framing;
use super::intermittent_tuning::IntermittentTuning;
use super::mean_bearing::{ExpectedReturn, MeanBearing, mean_bearing};
use super::movement::Ramps;
use super::prediction::{PredictedView, Prediction, TransferGoal};
use crate::bearing::{BearingFilter, Propagation};
use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::transfer::Pair;

/// The longest interval between two steps that a ramp counts, seconds.
const MAX_INTERVAL_S: f64 = 0.1;

/// Whatever the circumstances, start and stop ellipse are not smaller than this, semi-axes, ...
const MIN_ELLIPSE: f64 = 0.05;
/// ... and the camera does not cruise more slowly, rad/s.
const MIN_CRUISE_RATE: f64 = 0.05;

/// The optimal law in its intermittent mode, with its state.
#[derive(Debug, Clone)]
pub struct IntermittentLaw {
    tuning: IntermittentTuning,
    limits: Pair,
    min_rates: Pair,
    ramps: [Ramps; 2],
    bearings: BearingFilter,
    framing: Framing,
    mean_bearing: MeanBearing,
    usual_motion: UsualMotion,
    start_look_ahead: Propagation,
    stop_look_ahead: Propagation,
    command_in_force: CameraCommand,
    rested_since: Option<Timestamp>,
    last_step: Option<Timestamp>,
    /// The cruising rate of the present movement, rad/s.
    cruise_rate: f64,
    /// The rates that the axes are to hold, rad/s; 0: the axis does not take part.
    plateaus: Pair,
}

impl IntermittentLaw {
    /// A law without observations.
    pub fn new(tuning: IntermittentTuning, framed: Framed, profile: &VehicleProfile) -> Self {
        let AxisRates { pan, tilt } = profile.limits;
        let limits = [pan, tilt].map(AngularRate::radians_per_second);
        let axes = [&profile.camera.pan, &profile.camera.tilt];
        let min_rates = axes.map(|axis| axis.min_rate.radians_per_second());
        let lags_s = axes.map(|axis| axis.lag.as_secs_f64());
        let slower_s = lags_s[0].max(lags_s[1]);
        let responses_s = (tuning.start_response_share * slower_s, tuning.stop_response_share * slower_s);
        let look_ahead = |duration_s| Propagation::new(duration_s, &tuning.noise);
        Self {
            limits: [0, 1].map(|axis| limits[axis].min(tuning.max_rate.max(min_rates[axis]))),
            min_rates,
            ramps: [0, 1].map(|i| Ramps::new(lags_s[i], tuning.cruise_rate.base, responses_s, min_rates[i])),
            bearings: BearingFilter::new(tuning.noise),
            framing: Framing::new(framed),
            mean_bearing: mean_bearing(tuning.memory_s),
            usual_motion: usual_motion(),
            start_look_ahead: look_ahead(tuning.start_look_ahead_s),
            stop_look_ahead: look_ahead(tuning.stop_look_ahead_s),
            tuning,
            command_in_force: CameraCommand::REST,
            rested_since: None,
            last_step: None,
            cruise_rate: MIN_CRUISE_RATE,
            plateaus: [0.0; 2],
        }
    }

    /// Discards the observations of the target.
    pub fn reset_target(&mut self) {
        self.bearings.reset_target();
        self.mean_bearing = mean_bearing(self.tuning.memory_s);
        self.usual_motion = usual_motion();
    }

    /// Notes that `command` is in force from `now` on.
    pub fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        if command.is_rest() {
            if !self.command_in_force.is_rest() {
                self.rested_since = Some(now);
            }
            self.plateaus = [0.0; 2];
        }
        self.command_in_force = command;
    }

    /// Computes the command of one step.
    pub fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        let interval_s = self.last_step.map_or(0.0, |last| input.now.since(last).as_secs_f64());
        self.last_step = Some(input.now);
        let noise = self.tuning.noise;
        let Some(prediction) = Prediction::observed(&mut self.bearings, noise, input, camera) else {
            return CameraCommand::REST;
        };
        let prediction = prediction.held_in(self.framing.region(input));
        let mean = self.mean_bearing.observe(prediction.bearing.direction(), input.now);
        let return_time_s = self.tuning.return_time_s;
        let prediction = prediction.with_return(ExpectedReturn { mean, return_time_s });
        let resting = prediction.view_at_rest(&self.start_look_ahead);
        let circumstances = self.circumstances(&prediction, &resting, input.now);
        if self.command_in_force.is_rest() {
            if !self.leaves_start(prediction.region.p(resting.point), &circumstances, input.now) {
                return CameraCommand::REST;
            }
            self.cruise_rate = self.tuning.cruise_rate.value(&circumstances).max(MIN_CRUISE_RATE);
        }
        self.plateaus = if self.would_rest_inside_stop(&prediction, &circumstances) {
            [0.0; 2]
        } else {
            self.next_plateaus(&prediction)
        };
        let in_force = self.command_in_force;
        let before = [in_force.pan, in_force.tilt].map(AngularRate::radians_per_second);
        let interval_s = interval_s.min(MAX_INTERVAL_S);
        let [pan, tilt] = [0, 1]
            .map(|axis| self.ramps[axis].next(before[axis], self.plateaus[axis], interval_s))
            .map(AngularRate::from_radians_per_second);
        CameraCommand::turning(pan, tilt)
    }

    /// The circumstances now; `resting` is the view of a resting camera at the start's look-ahead.
    fn circumstances(
        &mut self,
        prediction: &Prediction<'_>,
        resting: &PredictedView,
        now: Timestamp,
    ) -> Circumstances {
        let observed = [prediction.bearing.angular_speed(), prediction.until_effect.duration_s];
        let [usual_rate, delay_s] = self.usual_motion.observe(observed, now);
        Circumstances {
            sway: prediction.in_semi_axes(self.bearings.sway_std_dev()),
            steepness: prediction.turning_effort(resting) - 1.0,
            usual_rate,
            delay_s: additional_delay_s(delay_s),
            lag_s: additional_lag_s(prediction.camera),
        }
    }

    /// Whether the target of a resting camera, predicted at this P, is outside of the start ellipse.
    fn leaves_start(&self, resting_p: f64, circumstances: &Circumstances, now: Timestamp) -> bool {
        let has_rested =
            self.rested_since.is_none_or(|since| now.since(since).as_secs_f64() >= self.tuning.min_rest_s);
        // The narrower the ellipse, the earlier the start: sway is not foreseen.
        let start = self.tuning.start.value(circumstances).max(MIN_ELLIPSE);
        has_rested && resting_p > start * start
    }

    /// Whether a camera that is told to rest now would have the target inside the stop ellipse.
    fn would_rest_inside_stop(&self, prediction: &Prediction<'_>, circumstances: &Circumstances) -> bool {
        let resting = prediction.view_at_rest(&self.stop_look_ahead);
        let stop = self.tuning.stop.value(circumstances).max(MIN_ELLIPSE);
        let is_outside = prediction.region.p(resting.point) > stop * stop;
        // A place that is not a number rests the camera.
        !is_outside
    }

    /// The plateaus of the movement from now on: new ones where it would miss the correction ellipse, and
    /// otherwise the present ones, lowered as far as less is enough.
    fn next_plateaus(&self, prediction: &Prediction<'_>) -> Pair {
        let tuning = &self.tuning;
        let goal = TransferGoal {
            horizon_s: tuning.horizon_s,
            look_ahead_s: tuning.aim_look_ahead_s,
            aim: tuning.aim,
        };
        let transfer = prediction.transfer(&goal, self.limits);
        let needed = transfer.solve().rates;
        let fastest = needed[0].abs().max(needed[1].abs());
        if fastest == 0.0 {
            return prediction.stoppable_rates(self.plateaus);
        }
        let faster = usize::from(needed[1].abs() > needed[0].abs());
        let cruise_rate = self.cruise_rate.max(self.min_rates[faster]);
        let scale = (cruise_rate / fastest).max(1.0);
        let limits = self.limits;
        let wanted = [0, 1].map(|axis| (scale * needed[axis]).clamp(-limits[axis], limits[axis]));
        let shares = needed.map(|rate| rate.abs() / fastest);
        let plateaus = if transfer.closest_passage(self.plateaus) <= tuning.correction {
            self.lowered_plateaus(wanted, shares, cruise_rate)
        } else {
            self.new_plateaus(wanted, shares)
        };
        prediction.stoppable_rates(plateaus)
    }

    fn new_plateaus(&self, wanted: Pair, shares: Pair) -> Pair {
        [0, 1].map(|axis| {
            let is_moving_so = self.plateaus[axis] * wanted[axis] > 0.0;
            let min_share = if is_moving_so { self.tuning.leave_share } else { self.tuning.join_share };
            if shares[axis] >= min_share { wanted[axis] } else { 0.0 }
        })
    }

    /// The faster axis slows down to the cruising rate at most; the other one may end its part.
    fn lowered_plateaus(&self, wanted: Pair, shares: Pair, cruise_rate: f64) -> Pair {
        let faster = usize::from(self.plateaus[1].abs() > self.plateaus[0].abs());
        [0, 1].map(|axis| {
            let held = self.plateaus[axis];
            let size = if wanted[axis] * held > 0.0 { wanted[axis].abs() } else { 0.0 };
            let size = if axis == faster {
                size.max(cruise_rate)
            } else if shares[axis] < self.tuning.leave_share {
                0.0
            } else {
                size
            };
            libm::copysign(size.min(held.abs()), held)
        })
    }
}
