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

use crate::bearing::{Bearing, BearingFilter, BearingNoise, Span};
use crate::camera_model::CameraModel;
use crate::law::Sight;
use crate::region::Region;
use crate::transfer::{Pair, Transfer};
use crate::view::View;

/// What is to be spared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
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
    pub mode: Mode,
    /// Within what time the target is to be back, seconds: short is tight, long is lazy. `None`: the mode's own.
    pub horizon_s: Option<f64>,
}

impl OptimalSettings {
    /// A mode with its own horizon.
    pub const fn of(mode: Mode) -> Self {
        Self { mode, horizon_s: None }
    }

    /// Horizons that make sense, seconds.
    pub const HORIZONS_S: core::ops::RangeInclusive<f64> = 0.5..=5.0;

    /// What these settings stand for.
    pub fn tuning(&self) -> Tuning {
        let tuning = match self.mode {
            Mode::MinimumEnergy => Tuning::MINIMUM_ENERGY,
            Mode::TimeFuel => Tuning::TIME_FUEL,
            Mode::Eco => Tuning::ECO,
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
    pub doubt: f64,
    /// It stops where the prediction with the camera at rest lies in this ellipse.
    pub stop: f64,
    /// It moves the target into this ellipse.
    pub aim: f64,
    /// Within what time, seconds, where the target is fast.
    pub horizon_s: f64,
    /// By what share that time is longer where it stands: there is time, and gentle movements take less energy.
    pub lazy: f64,
    /// How much longer that time is for each share of turning that it takes beyond a level camera's: looking down
    /// steeply, where pan hardly moves what is seen, there is little to be had for much energy.
    pub thrift: f64,
    /// By how much wider stop and aim are where it stands: what moves slowly need not be fetched far in.
    pub ease: f64,
    /// How far ahead it looks for the start, seconds, where the target is fast.
    pub start_ahead_s: f64,
    /// From what turn of the bearing on a target is fast, rad/s: for slower ones it looks less far ahead.
    pub fast: f64,
    /// And for the stop.
    pub stop_ahead_s: f64,
    /// Over what time it spreads the turning that takes a target that is inside of the aim already on to the stop,
    /// seconds; thrift makes it longer, too.
    pub drift_s: f64,
    /// The faster axis turns at least so fast, rad/s.
    pub least_rate: f64,
    /// It turns at most so fast, rad/s.
    pub most_rate: f64,
    /// An axis slower than this share of the other rests.
    pub least_share: f64,
    /// A command that differs by less from the one in force is not given, rad/s.
    pub hold: f64,
    /// How long the camera rests at least, seconds.
    pub least_rest_s: f64,
    /// How the target is taken to move.
    pub noise: BearingNoise,
}

/// How the target is taken to move by the modes that move in bursts.
const IN_BURSTS: BearingNoise =
    BearingNoise { rate: 0.0855, memory_s: 2.253, look: 0.0013, sway: 0.0149, sway_memory_s: 5.02 };

impl Tuning {
    /// [`Mode::MinimumEnergy`].
    pub const MINIMUM_ENERGY: Self = Self {
        start: 0.85,
        doubt: 0.1,
        stop: 0.04,
        aim: 0.704,
        horizon_s: 1.22,
        lazy: 0.009,
        thrift: 1.5,
        ease: 0.098,
        start_ahead_s: 1.7,
        fast: 0.0236,
        stop_ahead_s: 0.165,
        drift_s: 6.5,
        least_rate: 0.01,
        most_rate: 0.34,
        least_share: 0.62,
        hold: 0.0,
        least_rest_s: 0.11,
        noise: BearingNoise { rate: 0.088, memory_s: 2.4, look: 0.002, sway: 0.031, sway_memory_s: 4.76 },
    };
    /// [`Mode::TimeFuel`].
    pub const TIME_FUEL: Self = Self {
        start: 0.98,
        doubt: 0.0,
        stop: 0.7,
        aim: 0.7,
        horizon_s: 2.0,
        lazy: 0.0,
        thrift: 0.0,
        ease: 0.0,
        start_ahead_s: 0.3,
        fast: 0.1,
        stop_ahead_s: 0.6,
        drift_s: 6.0,
        least_rate: 0.28,
        most_rate: 0.3,
        least_share: 0.12,
        hold: 0.06,
        least_rest_s: 0.3,
        noise: IN_BURSTS,
    };
    /// [`Mode::Eco`].
    pub const ECO: Self = Self {
        start: 1.033,
        doubt: 0.2,
        stop: 0.735,
        aim: 0.518,
        horizon_s: 1.806,
        lazy: 0.145,
        thrift: 0.426,
        ease: 0.043,
        start_ahead_s: 0.111,
        fast: 0.185,
        stop_ahead_s: 0.986,
        drift_s: 6.0,
        least_rate: 0.288,
        most_rate: 0.333,
        least_share: 0.59,
        hold: 0.0196,
        least_rest_s: 0.335,
        noise: IN_BURSTS,
    };
}

/// Inside of the aim it is moved to this share of the stop.
const DRIFT_SHARE: f64 = 0.8;
/// Where an end stop leaves an axis less than this, rad/s, it rests.
const LEAST_LEFT: f64 = 0.01;

/// The law with what it remembers.
#[derive(Debug, Clone)]
pub struct OptimalLaw {
    tuning: Tuning,
    limits: Pair,
    least: Pair,
    bearings: BearingFilter,
    /// How far it looks ahead for the stop.
    stop_ahead: Span,
    in_force: CameraCommand,
    rested_since: Option<Timestamp>,
}

/// What is predicted for one moment.
#[derive(Debug, Clone, Copy)]
struct Outlook {
    view: View,
    point: ImagePoint,
    /// For how long the bearing's rate counts until then, as it fades, and what is left of the sway.
    reach_s: f64,
    sway_left: f64,
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
    until_effect: Span,
    /// The slower axis' dead time, seconds.
    start_s: f64,
}

impl OptimalLaw {
    /// A law that has seen nothing.
    pub fn new(settings: &OptimalSettings, profile: &VehicleProfile) -> Self {
        Self::tuned(settings.tuning(), profile)
    }

    /// A law with a tuning of one's own.
    pub fn tuned(tuning: Tuning, profile: &VehicleProfile) -> Self {
        let AxisRates { pan, tilt } = profile.limits;
        let limits = [pan, tilt].map(AngularRate::radians_per_second);
        let least =
            [&profile.camera.pan, &profile.camera.tilt].map(|axis| axis.least_rate.radians_per_second());
        Self {
            limits: [0, 1].map(|axis| limits[axis].min(tuning.most_rate.max(least[axis]))),
            least,
            bearings: BearingFilter::new(tuning.noise),
            stop_ahead: Span::new(tuning.stop_ahead_s, &tuning.noise),
            tuning,
            in_force: CameraCommand::REST,
            rested_since: None,
        }
    }

    /// Forgets what it has seen of a target.
    pub fn forget(&mut self) {
        self.bearings.forget();
    }

    /// This command is in force from `now` on.
    pub fn in_force(&mut self, command: CameraCommand, now: Timestamp) {
        if command.is_rest() && !self.in_force.is_rest() {
            self.rested_since = Some(now);
        }
        self.in_force = command;
    }

    /// What to ask of the camera.
    pub fn command(&mut self, sight: &Sight<'_>, camera: &CameraModel) -> CameraCommand {
        let view = self.bearings.see(sight, camera);
        let Some((looked, bearing)) = self.bearings.known() else { return CameraCommand::REST };
        let start_s = camera.axes().map(|axis| axis.start_s()).into_iter().fold(0.0, f64::max);
        let noise = self.tuning.noise;
        let age_s = sight.now.since(*looked).as_secs_f64() + start_s;
        let prediction = Prediction {
            camera,
            view,
            focal_px: camera.focal_px(sight.now, sight.picture),
            region: sight.region,
            bearing: *bearing,
            noise,
            until_effect: Span::new(age_s, &noise),
            start_s,
        };
        let left = if self.in_force.is_rest() {
            self.leaves(&prediction, sight.now)
        } else {
            self.not_yet_back(&prediction)
        };
        left.map_or(CameraCommand::REST, |outlook| self.rates(&prediction, &outlook))
    }

    /// The stop ellipse for a target that leaves so much leisure: from 0 where it is fast to 1 where it stands.
    fn stop(&self, leisure: f64) -> f64 {
        self.tuning.stop + self.tuning.ease * leisure
    }

    /// How fast the target is: from 0 where it stands to 1.
    fn pace(&self, prediction: &Prediction<'_>) -> f64 {
        (prediction.bearing.speed() / self.tuning.fast).min(1.0)
    }

    /// Where a resting camera would see the target leave the start ellipse.
    fn leaves(&self, prediction: &Prediction<'_>, now: Timestamp) -> Option<Outlook> {
        let rested =
            self.rested_since.is_none_or(|since| now.since(since).as_secs_f64() >= self.tuning.least_rest_s);
        if !rested {
            return None;
        }
        let ahead_s = self.pace(prediction) * self.tuning.start_ahead_s;
        let half = Span::new(0.5 * ahead_s, &self.tuning.noise);
        [Span::NONE, half, half.and(&half)].iter().map(|span| prediction.resting(span)).find(|resting| {
            let start = self.tuning.start + self.tuning.doubt * prediction.doubt(resting);
            prediction.region.p(resting.point) > start * start
        })
    }

    /// Where a camera that is told now to rest would leave the target, if that is not in the stop ellipse yet.
    fn not_yet_back(&self, prediction: &Prediction<'_>) -> Option<Outlook> {
        let resting = prediction.resting(&self.stop_ahead);
        let stop = self.stop(1.0 - self.pace(prediction));
        (prediction.region.p(resting.point) > stop * stop).then_some(resting)
    }

    /// The rates of a camera that moves, because the target would be seen there if it did not.
    fn rates(&self, prediction: &Prediction<'_>, resting: &Outlook) -> CameraCommand {
        let leisure = 1.0 - self.pace(prediction);
        let thrift = 1.0 + self.tuning.thrift * (prediction.effort(resting) - 1.0);
        let horizon_s = (1.0 + self.tuning.lazy * leisure) * thrift * self.tuning.horizon_s;
        let transfer =
            prediction.transfer(horizon_s, self.tuning.aim + self.tuning.ease * leisure, self.limits);
        let mut wanted = transfer.solve().rates;
        let mut fastest = wanted[0].abs().max(wanted[1].abs());
        if fastest == 0.0 {
            // It drifts in by itself, but not far enough to rest: there is time.
            let aim = DRIFT_SHARE * self.stop(leisure);
            let slower = horizon_s / (thrift * thrift * self.tuning.drift_s);
            let drift = Transfer { aim, ..transfer }.solve();
            wanted = drift.rates.map(|rate| slower * rate);
            fastest = wanted[0].abs().max(wanted[1].abs());
            if fastest == 0.0 {
                // It comes on by itself; or nothing that the axes may do brings it nearer.
                return if drift.arrives { self.in_force } else { CameraCommand::REST };
            }
        }
        let faster = usize::from(wanted[1].abs() > wanted[0].abs());
        let raised = (self.tuning.least_rate.max(self.least[faster]) / fastest).max(1.0);
        let before = [self.in_force.pan, self.in_force.tilt].map(AngularRate::radians_per_second);
        let mut rates = [0.0; 2];
        for axis in [0, 1] {
            let rate = wanted[axis] * raised;
            let share = wanted[axis].abs() / fastest;
            let (least, most) = (transfer.least[axis], transfer.most[axis]);
            let left = if rate < 0.0 { -least } else { most };
            rates[axis] = if share < self.tuning.least_share || left < LEAST_LEFT.max(self.least[axis]) {
                0.0
            } else {
                at_least(rate, self.least[axis]).clamp(least, most)
            };
        }
        let changed = (0..2).any(|axis| (rates[axis] - before[axis]).abs() >= self.tuning.hold);
        if !changed && !self.in_force.is_rest() {
            return self.in_force;
        }
        let [pan, tilt] = rates.map(AngularRate::from_radians_per_second);
        CameraCommand { pan, tilt }
    }
}

impl Prediction<'_> {
    /// Where the target will be seen if the camera is told now to rest.
    fn resting(&self, span: &Span) -> Outlook {
        let angles =
            self.camera.axes().map(|axis| axis.angle_resting(span.span_s + self.start_s - axis.start_s()));
        self.outlook(span, angles)
    }

    /// How much more turning it takes to move the target from there to the middle than it takes a camera that looks level;
    /// at least 1, and at most 4 where pan moves nothing.
    fn effort(&self, Outlook { view, point, .. }: &Outlook) -> f64 {
        const LEAST_GAIN: f64 = 0.25;
        let gains = view.sensitivity(*point);
        let across = point.x * self.focal_px / gains.pan[0].abs().max(LEAST_GAIN * self.focal_px);
        let along = point.y * self.focal_px / gains.tilt[1].abs().max(LEAST_GAIN * self.focal_px);
        let level = (point.x * point.x + point.y * point.y).max(1.0);
        libm::sqrt(((across * across + along * along) / level).max(1.0))
    }

    /// The deviation of what is known of the target's motion by then, in the region's smaller semi-axis.
    fn doubt(&self, then: &Outlook) -> f64 {
        let deviation = self.bearing.doubt_after(then.reach_s, then.sway_left);
        self.focal_px * deviation / self.region.a_px.min(self.region.b_px)
    }

    fn outlook(&self, span: &Span, [pan, tilt]: Pair) -> Outlook {
        let Span { rate_left, sway_left, .. } = self.until_effect.and(span);
        let reach_s = self.noise.memory_s * (1.0 - rate_left);
        let view = self.view.turned(self.focal_px, pan, tilt);
        let point = view.point(self.bearing.seen_after(reach_s, sway_left));
        Outlook { view, point, reach_s, sway_left }
    }

    /// The problem of bringing the target into the aim within the horizon.
    fn transfer(&self, horizon_s: f64, aim: f64, limits: Pair) -> Transfer {
        let (mut reach, mut angles) = ([0.0; 2], [0.0; 2]);
        let (mut least, mut most) = (limits.map(|limit| -limit), limits);
        for (index, axis) in self.camera.axes().into_iter().enumerate() {
            let span_s = horizon_s + self.start_s - axis.start_s();
            let left = axis.fading(span_s);
            reach[index] = span_s - axis.lag_s() * (1.0 - left);
            angles[index] = axis.angle_coasting(left);
            if let Some((below, above)) = axis.left_to_stops(angles[index]) {
                least[index] = least[index].max(-below / reach[index]);
                most[index] = most[index].min(above / reach[index]);
            }
        }
        let coasting = self.outlook(&Span::new(horizon_s, &self.noise), angles);
        let gains = coasting.view.sensitivity(coasting.point);
        let (a, b) = (self.region.a_px, self.region.b_px);
        Transfer {
            offset: [coasting.point.x / a, coasting.point.y / b],
            pan: [gains.pan[0] * reach[0] / a, gains.pan[1] * reach[0] / b],
            tilt: [gains.tilt[0] * reach[1] / a, gains.tilt[1] * reach[1] / b],
            aim,
            least,
            most,
        }
    }
}

/// A rate that the vehicle can turn at: below half its least it rests.
fn at_least(rate: f64, least: f64) -> f64 {
    if rate.abs() >= least {
        rate
    } else if rate.abs() >= 0.5 * least {
        libm::copysign(least, rate)
    } else {
        0.0
    }
}
