//! The optimal law: both axes at once, with the least energy that brings the target back, started by a prediction.
//!
//! Where the target will be by the time at which a command counts is predicted ([`BearingFilter`], [`CameraModel`]).
//! While the prediction stays well inside of the region the camera rests. Where it leaves the *start* ellipse within
//! the look-ahead, the camera starts, and from then on each look asks anew: which constant rates take the target into
//! the *aim* ellipse within the horizon with the least `∫|u|² dt` ([`Transfer`])? Where the camera, told to rest now,
//! would leave the target inside the *stop* ellipse, it is told to rest. `docs/optimal-law.md` derives it and draws
//! the ellipses.
//!
//! What must not be here: whether the camera may move at all (the pilot's safety judges), and the vehicle's signs.
//! O(1), no allocation.

use barrelman_vocab::profile::{AxisRates, VehicleProfile};
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, Timestamp};

use crate::bearing::{Bearing, BearingFilter, BearingNoise, Propagation};
use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::region::Region;
use crate::transfer::{Pair, Transfer};
use crate::view::View;

/// What is to be spared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OptimalMode {
    /// The integral of the squared rate: the camera moves gently, and for longer.
    #[default]
    MinimumEnergy,
    /// The time in motion, too: the camera moves at a cruising speed, and rests.
    TimeFuel,
    /// All of it: less of everything than the schema, at the price of more time outside than the others have.
    Eco,
}

/// The optimal law's settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OptimalSettings {
    /// What is to be spared.
    pub mode: OptimalMode,
    /// Within what time the target is to be back, seconds: short is tight, long is lazy. `None`: the mode's own.
    pub horizon_s: Option<f64>,
}

impl OptimalSettings {
    /// A mode with its own horizon.
    pub const fn new(mode: OptimalMode) -> Self {
        Self { mode, horizon_s: None }
    }

    /// Horizons that make sense, seconds.
    pub const HORIZONS_S: core::ops::RangeInclusive<f64> = 0.5..=5.0;

    /// What these settings stand for.
    pub fn tuning(&self) -> Tuning {
        let tuning = match self.mode {
            OptimalMode::MinimumEnergy => Tuning::MINIMUM_ENERGY,
            OptimalMode::TimeFuel => Tuning::TIME_FUEL,
            OptimalMode::Eco => Tuning::ECO,
        };
        Tuning { horizon_s: self.horizon_s.unwrap_or(tuning.horizon_s), ..tuning }
    }
}

/// Everything that the law is tuned by. Distances are in semi-axes of the region: 1 is its ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// The camera starts where the prediction leaves this ellipse.
    pub start: f64,
    /// By how many deviations of the prediction it must do so, where that lies ahead: what is not certain can wait.
    pub start_sigma: f64,
    /// It stops where the prediction with the camera at rest lies in this ellipse.
    pub stop: f64,
    /// It moves the target into this ellipse.
    pub aim: f64,
    /// Within what time, seconds, where the target is fast.
    pub horizon_s: f64,
    /// By what share that time is longer where it stands: there is time, and gentle movements take less energy.
    pub slow_target_gain: f64,
    /// How much longer that time is for each share of turning that it takes beyond a level camera's: looking down
    /// steeply, where pan hardly moves what is seen, there is little to be had for much energy.
    pub steep_view_gain: f64,
    /// By how much wider stop and aim are where it stands: what moves slowly need not be fetched far in.
    pub slow_target_widening: f64,
    /// How far ahead it looks for the start, seconds, where the target is fast.
    pub start_look_ahead_s: f64,
    /// From what turn of the bearing on a target is fast, rad/s: for slower ones it looks less far ahead.
    pub fast_target_rate: f64,
    /// And for the stop.
    pub stop_look_ahead_s: f64,
    /// Over what time it spreads the turning that takes a target that is inside of the aim already on to the stop,
    /// seconds; thrift makes it longer, too.
    pub recentring_time_s: f64,
    /// The faster axis turns at least so fast, rad/s.
    pub min_rate: f64,
    /// It turns at most so fast, rad/s.
    pub max_rate: f64,
    /// An axis slower than this share of the other rests.
    pub min_axis_share: f64,
    /// A command that differs by less from the one in force is not given, rad/s.
    pub command_deadband: f64,
    /// How long the camera rests at least, seconds.
    pub min_rest_s: f64,
    /// How the target is taken to move.
    pub noise: BearingNoise,
}

/// How the target is taken to move by the modes that move in bursts.
const IN_BURSTS: BearingNoise = BearingNoise {
    rate_std_dev: 0.0855,
    rate_time_constant_s: 2.253,
    measurement_std_dev: 0.0013,
    max_sway_std_dev: 0.0149,
    sway_time_constant_s: 5.02,
};

impl Tuning {
    /// [`OptimalMode::MinimumEnergy`].
    pub const MINIMUM_ENERGY: Self = Self {
        start: 0.85,
        start_sigma: 0.1,
        stop: 0.04,
        aim: 0.704,
        horizon_s: 1.22,
        slow_target_gain: 0.009,
        steep_view_gain: 1.5,
        slow_target_widening: 0.098,
        start_look_ahead_s: 1.7,
        fast_target_rate: 0.0236,
        stop_look_ahead_s: 0.165,
        recentring_time_s: 6.5,
        min_rate: 0.01,
        max_rate: 0.34,
        min_axis_share: 0.62,
        command_deadband: 0.0,
        min_rest_s: 0.11,
        noise: BearingNoise {
            rate_std_dev: 0.088,
            rate_time_constant_s: 2.4,
            measurement_std_dev: 0.002,
            max_sway_std_dev: 0.031,
            sway_time_constant_s: 4.76,
        },
    };
    /// [`OptimalMode::TimeFuel`].
    pub const TIME_FUEL: Self = Self {
        start: 0.98,
        start_sigma: 0.0,
        stop: 0.7,
        aim: 0.7,
        horizon_s: 2.0,
        slow_target_gain: 0.0,
        steep_view_gain: 0.0,
        slow_target_widening: 0.0,
        start_look_ahead_s: 0.3,
        fast_target_rate: 0.1,
        stop_look_ahead_s: 0.6,
        recentring_time_s: 6.0,
        min_rate: 0.28,
        max_rate: 0.3,
        min_axis_share: 0.12,
        command_deadband: 0.06,
        min_rest_s: 0.3,
        noise: IN_BURSTS,
    };
    /// [`OptimalMode::Eco`].
    pub const ECO: Self = Self {
        start: 1.033,
        start_sigma: 0.2,
        stop: 0.735,
        aim: 0.518,
        horizon_s: 1.806,
        slow_target_gain: 0.145,
        steep_view_gain: 0.426,
        slow_target_widening: 0.043,
        start_look_ahead_s: 0.111,
        fast_target_rate: 0.185,
        stop_look_ahead_s: 0.986,
        recentring_time_s: 6.0,
        min_rate: 0.288,
        max_rate: 0.333,
        min_axis_share: 0.59,
        command_deadband: 0.0196,
        min_rest_s: 0.335,
        noise: IN_BURSTS,
    };
}

/// Inside of the aim it is moved to this share of the stop.
const DRIFT_SHARE: f64 = 0.8;
/// Where an end stop leaves an axis less than this, rad/s, it rests.
const MIN_RATE_TO_STOP: f64 = 0.01;

/// The law with what it remembers.
#[derive(Debug, Clone)]
pub struct OptimalLaw {
    tuning: Tuning,
    limits: Pair,
    min_rates: Pair,
    bearings: BearingFilter,
    /// How far it looks ahead for the stop.
    stop_ahead: Propagation,
    in_force: CameraCommand,
    rested_since: Option<Timestamp>,
}

/// What is predicted for one moment.
#[derive(Debug, Clone, Copy)]
struct PredictedView {
    view: View,
    point: ImagePoint,
    /// For how long the bearing's rate counts until then, as it fades, and what is left of the sway.
    rate_gain_s: f64,
    sway_decay: f64,
}

/// The prediction of one step: everything at `span` after the time from which a command given now counts.
struct Prediction<'a> {
    camera: &'a CameraModel,
    /// The camera as of the picture.
    view: View,
    focal_px: f64,
    region: Region,
    bearing: Bearing,
    noise: BearingNoise,
    /// From the bearing to the time from which a command counts.
    until_effect: Propagation,
    /// The slower axis' dead time, seconds.
    start_s: f64,
}

impl OptimalLaw {
    /// A law that has seen nothing.
    pub fn new(settings: &OptimalSettings, profile: &VehicleProfile) -> Self {
        Self::with_tuning(settings.tuning(), profile)
    }

    /// A law with a tuning of one's own.
    pub fn with_tuning(tuning: Tuning, profile: &VehicleProfile) -> Self {
        let AxisRates { pan, tilt } = profile.limits;
        let limits = [pan, tilt].map(AngularRate::radians_per_second);
        let min_rates =
            [&profile.camera.pan, &profile.camera.tilt].map(|axis| axis.min_rate.radians_per_second());
        Self {
            limits: [0, 1].map(|axis| limits[axis].min(tuning.max_rate.max(min_rates[axis]))),
            min_rates,
            bearings: BearingFilter::new(tuning.noise),
            stop_ahead: Propagation::new(tuning.stop_look_ahead_s, &tuning.noise),
            tuning,
            in_force: CameraCommand::REST,
            rested_since: None,
        }
    }

    /// Forgets what it has seen of a target.
    pub fn reset_target(&mut self) {
        self.bearings.reset_target();
    }

    /// This command is in force from `now` on.
    pub fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        if command.is_rest() && !self.in_force.is_rest() {
            self.rested_since = Some(now);
        }
        self.in_force = command;
    }

    /// What to ask of the camera.
    pub fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        let view = self.bearings.observe(input, camera);
        let Some((looked, bearing)) = self.bearings.estimate() else { return CameraCommand::REST };
        let start_s = camera.axes().map(|axis| axis.start_s()).into_iter().fold(0.0, f64::max);
        let noise = self.tuning.noise;
        let age_s = input.now.since(*looked).as_secs_f64() + start_s;
        let prediction = Prediction {
            camera,
            view,
            focal_px: camera.focal_px(input.now, input.picture),
            region: input.region,
            bearing: *bearing,
            noise,
            until_effect: Propagation::new(age_s, &noise),
            start_s,
        };
        let left = if self.in_force.is_rest() {
            self.predicted_exit(&prediction, input.now)
        } else {
            self.outside_stop(&prediction)
        };
        left.map_or(CameraCommand::REST, |predicted| self.rates(&prediction, &predicted))
    }

    /// The stop ellipse for a target that leaves so much slowness: from 0 where it is fast to 1 where it stands.
    fn stop(&self, slowness: f64) -> f64 {
        self.tuning.stop + self.tuning.slow_target_widening * slowness
    }

    /// How fast the target is: from 0 where it stands to 1.
    fn speed_share(&self, prediction: &Prediction<'_>) -> f64 {
        (prediction.bearing.angular_speed() / self.tuning.fast_target_rate).min(1.0)
    }

    /// Where a resting camera would see the target leave the start ellipse.
    fn predicted_exit(&self, prediction: &Prediction<'_>, now: Timestamp) -> Option<PredictedView> {
        let rested =
            self.rested_since.is_none_or(|since| now.since(since).as_secs_f64() >= self.tuning.min_rest_s);
        if !rested {
            return None;
        }
        let ahead_s = self.speed_share(prediction) * self.tuning.start_look_ahead_s;
        let half = Propagation::new(0.5 * ahead_s, &self.tuning.noise);
        [Propagation::ZERO, half, half.then(&half)].iter().map(|span| prediction.view_at_rest(span)).find(
            |resting| {
                let start = self.tuning.start + self.tuning.start_sigma * prediction.start_std_dev(resting);
                prediction.region.p(resting.point) > start * start
            },
        )
    }

    /// Where a camera that is told now to rest would leave the target, if that is not in the stop ellipse yet.
    fn outside_stop(&self, prediction: &Prediction<'_>) -> Option<PredictedView> {
        let resting = prediction.view_at_rest(&self.stop_ahead);
        let stop = self.stop(1.0 - self.speed_share(prediction));
        (prediction.region.p(resting.point) > stop * stop).then_some(resting)
    }

    /// The rates of a camera that moves, because the target would be seen there if it did not.
    fn rates(&self, prediction: &Prediction<'_>, resting: &PredictedView) -> CameraCommand {
        let slowness = 1.0 - self.speed_share(prediction);
        let thrift = 1.0 + self.tuning.steep_view_gain * (prediction.turning_effort(resting) - 1.0);
        let horizon_s = (1.0 + self.tuning.slow_target_gain * slowness) * thrift * self.tuning.horizon_s;
        let transfer = prediction.transfer(
            horizon_s,
            self.tuning.aim + self.tuning.slow_target_widening * slowness,
            self.limits,
        );
        let mut wanted = transfer.solve().rates;
        let mut fastest = wanted[0].abs().max(wanted[1].abs());
        if fastest == 0.0 {
            // It drifts in by itself, but not far enough to rest: there is time.
            let aim = DRIFT_SHARE * self.stop(slowness);
            let slower = horizon_s / (thrift * thrift * self.tuning.recentring_time_s);
            let drift = Transfer { aim, ..transfer }.solve();
            wanted = drift.rates.map(|rate| slower * rate);
            fastest = wanted[0].abs().max(wanted[1].abs());
            if fastest == 0.0 {
                // It comes on by itself; or nothing that the axes may do brings it nearer.
                return if drift.reaches_aim { self.in_force } else { CameraCommand::REST };
            }
        }
        let faster = usize::from(wanted[1].abs() > wanted[0].abs());
        let raised = (self.tuning.min_rate.max(self.min_rates[faster]) / fastest).max(1.0);
        let before = [self.in_force.pan, self.in_force.tilt].map(AngularRate::radians_per_second);
        let mut rates = [0.0; 2];
        for axis in [0, 1] {
            let rate = wanted[axis] * raised;
            let share = wanted[axis].abs() / fastest;
            let (least, most) = (transfer.min_rates[axis], transfer.max_rates[axis]);
            let left = if rate < 0.0 { -least } else { most };
            rates[axis] =
                if share < self.tuning.min_axis_share || left < MIN_RATE_TO_STOP.max(self.min_rates[axis]) {
                    0.0
                } else {
                    snap_to_min_rate(rate, self.min_rates[axis]).clamp(least, most)
                };
        }
        let changed = (0..2).any(|axis| (rates[axis] - before[axis]).abs() >= self.tuning.command_deadband);
        if !changed && !self.in_force.is_rest() {
            return self.in_force;
        }
        let [pan, tilt] = rates.map(AngularRate::from_radians_per_second);
        CameraCommand { pan, tilt }
    }
}

impl Prediction<'_> {
    /// Where the target will be seen if the camera is told now to rest.
    fn view_at_rest(&self, span: &Propagation) -> PredictedView {
        let angles = self
            .camera
            .axes()
            .map(|axis| axis.angle_if_rested(span.duration_s + self.start_s - axis.start_s()));
        self.predicted_view(span, angles)
    }

    /// How much more turning it takes to move the target from there to the middle than it takes a camera that looks level;
    /// at least 1, and at most 4 where pan moves nothing.
    fn turning_effort(&self, PredictedView { view, point, .. }: &PredictedView) -> f64 {
        const MIN_GAIN: f64 = 0.25;
        let gains = view.jacobian(*point);
        let across = point.x * self.focal_px / gains.pan[0].abs().max(MIN_GAIN * self.focal_px);
        let along = point.y * self.focal_px / gains.tilt[1].abs().max(MIN_GAIN * self.focal_px);
        let level = (point.x * point.x + point.y * point.y).max(1.0);
        libm::sqrt(((across * across + along * along) / level).max(1.0))
    }

    /// The deviation of what is known of the target's motion by then, in the region's smaller semi-axis.
    fn start_std_dev(&self, then: &PredictedView) -> f64 {
        let deviation = self.bearing.predicted_std_dev(then.rate_gain_s, then.sway_decay);
        self.focal_px * deviation / self.region.a_px.min(self.region.b_px)
    }

    fn predicted_view(&self, span: &Propagation, [pan, tilt]: Pair) -> PredictedView {
        let Propagation { rate_decay, sway_decay, .. } = self.until_effect.then(span);
        let rate_gain_s = self.noise.rate_time_constant_s * (1.0 - rate_decay);
        let view = self.view.with_pointing(self.focal_px, pan, tilt);
        let point = view.project(self.bearing.apparent_direction_after(rate_gain_s, sway_decay));
        PredictedView { view, point, rate_gain_s, sway_decay }
    }

    /// The problem of bringing the target into the aim within the horizon.
    fn transfer(&self, horizon_s: f64, aim: f64, limits: Pair) -> Transfer {
        let (mut reach, mut angles) = ([0.0; 2], [0.0; 2]);
        let (mut min_rates, mut max_rates) = (limits.map(|limit| -limit), limits);
        for (index, axis) in self.camera.axes().into_iter().enumerate() {
            let duration_s = horizon_s + self.start_s - axis.start_s();
            let left = axis.rate_decay(duration_s);
            reach[index] = duration_s - axis.lag_s() * (1.0 - left);
            angles[index] = axis.angle_coasting(left);
            if let Some((below, above)) = axis.range_to_stops(angles[index]) {
                min_rates[index] = min_rates[index].max(-below / reach[index]);
                max_rates[index] = max_rates[index].min(above / reach[index]);
            }
        }
        let coasting = self.predicted_view(&Propagation::new(horizon_s, &self.noise), angles);
        let gains = coasting.view.jacobian(coasting.point);
        let (a, b) = (self.region.a_px, self.region.b_px);
        Transfer {
            offset: [coasting.point.x / a, coasting.point.y / b],
            pan: [gains.pan[0] * reach[0] / a, gains.pan[1] * reach[0] / b],
            tilt: [gains.tilt[0] * reach[1] / a, gains.tilt[1] * reach[1] / b],
            aim,
            min_rates,
            max_rates,
        }
    }
}

/// A rate that the vehicle can turn at: below half its least it rests.
fn snap_to_min_rate(rate: f64, least: f64) -> f64 {
    if rate.abs() >= least {
        rate
    } else if rate.abs() >= 0.5 * least {
        libm::copysign(least, rate)
    } else {
        0.0
    }
}
