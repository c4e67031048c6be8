//! The bearing filter: in what direction the target is and how fast that turns, in a frame that does not turn with the
//! camera.
//!
//! A Kalman filter on the sphere, the same in every direction across the line of input. The target's rate is an
//! Ornstein-Uhlenbeck process (it keeps its value for about [`BearingNoise::rate_time_constant_s`] and has the deviation
//! [`BearingNoise::rate_std_dev`] in each of two directions), its bearing the integral of that. The kite's own sway, which is in
//! no command, is another such process on the bearing itself: it jumps about, and drifts back. How far looks lie from
//! what was predicted says how much sway there is. Steps are as long as the pictures are apart; a picture that comes
//! again is no look; through a gap the covariance grows as it should. O(1), no allocation.

use barrelman_vocab::Timestamp;

use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::view::View;

pub use crate::view::Direction;

/// How a target's bearing turns and how well it is seen; deviations are those in each of two directions across the line
/// of input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingNoise {
    /// Deviation of the bearing's rate, rad/s.
    pub rate_std_dev: f64,
    /// How long the rate keeps its value, seconds.
    pub rate_time_constant_s: f64,
    /// Deviation of a look where nothing sways, rad.
    pub measurement_std_dev: f64,
    /// The most that the kite's sway is taken to be, rad: up to that it follows what the looks themselves show.
    pub max_sway_std_dev: f64,
    /// How long the sway keeps its value, seconds.
    pub sway_time_constant_s: f64,
}

/// Symmetric: bearing, rate, sway.
type Covariance = [[f64; 3]; 3];

/// A bearing, how fast it turns, and how well both are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// Where the target is, without the sway.
    direction: Direction,
    /// How the direction changes, 1/s; across the direction.
    rate: [f64; 3],
    /// By what the sway shifts it; across the direction.
    sway: [f64; 3],
    covariance: Covariance,
}

/// Rates beyond this are no target's, rad/s.
const MAX_RATE: f64 = 1.0;
/// Innovations beyond so many deviations are taken for so many: a jump of the tracker counts for less.
const INNOVATION_GATE: f64 = 4.0;
/// A look shows at most so many times the most variance of the sway.
const MAX_SWAY_SAMPLE: f64 = 4.0;
/// Without a look for so long it begins anew, seconds.
const MAX_GAP_S: f64 = 0.6;
/// How long what looks show of the sway counts, seconds.
const SWAY_TIME_CONSTANT_S: f64 = 2.0;

/// A span of time, and what is left of the rate and of the sway at its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Propagation {
    pub(crate) duration_s: f64,
    pub(crate) rate_decay: f64,
    pub(crate) sway_decay: f64,
}

impl Propagation {
    /// No time: everything is left.
    pub(crate) const ZERO: Self = Self { duration_s: 0.0, rate_decay: 1.0, sway_decay: 1.0 };

    /// So many seconds.
    pub(crate) fn new(duration_s: f64, noise: &BearingNoise) -> Self {
        Self {
            duration_s,
            rate_decay: libm::exp(-duration_s / noise.rate_time_constant_s),
            sway_decay: libm::exp(-duration_s / noise.sway_time_constant_s),
        }
    }

    /// One after the other.
    pub(crate) fn then(&self, next: &Self) -> Self {
        Self {
            duration_s: self.duration_s + next.duration_s,
            rate_decay: self.rate_decay * next.rate_decay,
            sway_decay: self.sway_decay * next.sway_decay,
        }
    }
}

impl Bearing {
    /// After a first look, where the sway has that variance: what it shows is bearing and sway together.
    fn from_first_measurement(direction: Direction, noise: &BearingNoise, sway_variance: f64) -> Self {
        let mut covariance = [[0.0; 3]; 3];
        covariance[0][0] = noise.measurement_std_dev * noise.measurement_std_dev + sway_variance;
        covariance[1][1] = noise.rate_std_dev * noise.rate_std_dev;
        covariance[2][2] = sway_variance;
        (covariance[0][2], covariance[2][0]) = (-sway_variance, -sway_variance);
        Self { direction, rate: [0.0; 3], sway: [0.0; 3], covariance }
    }

    /// In what direction the target is seen, the sway in it.
    pub fn apparent_direction(&self) -> Direction {
        unit([0, 1, 2].map(|i| self.direction[i] + self.sway[i]))
    }

    /// Variance of that direction in each of two directions across, rad².
    pub fn variance(&self) -> f64 {
        let [of_bearing, _, of_sway] = self.covariance;
        of_bearing[0] + 2.0 * of_bearing[2] + of_sway[2]
    }

    /// In what direction it will be seen when its rate has gone on for so long and so much of the sway is left; somewhat
    /// longer than a unit vector.
    pub(crate) fn apparent_direction_after(&self, rate_gain_s: f64, sway_decay: f64) -> Direction {
        [0, 1, 2].map(|i| self.direction[i] + rate_gain_s * self.rate[i] + sway_decay * self.sway[i])
    }

    /// Deviation, rad, of what its rate and the sway make of that direction.
    pub(crate) fn predicted_std_dev(&self, rate_gain_s: f64, sway_decay: f64) -> f64 {
        let row = [1.0, rate_gain_s, sway_decay];
        let variance: f64 =
            (0..3).map(|i| (0..3).map(|j| row[i] * row[j] * self.covariance[i][j]).sum::<f64>()).sum();
        libm::sqrt((variance - self.variance()).max(0.0))
    }

    /// How fast the bearing turns, rad/s.
    pub fn angular_speed(&self) -> f64 {
        libm::sqrt(dot(self.rate, self.rate))
    }

    /// So much later, unseen, where the sway has that variance.
    fn propagated(&self, span: &Propagation, noise: &BearingNoise, sway_variance: f64) -> Self {
        let Propagation { duration_s, rate_decay: kept, sway_decay } = *span;
        let memory = noise.rate_time_constant_s;
        let reach = memory * (1.0 - kept);
        let variance = noise.rate_std_dev * noise.rate_std_dev;
        let wander = variance * memory * (2.0 * duration_s - memory * (3.0 - kept * (4.0 - kept)));
        let [[bb, br, bs], [_, rr, rs], [_, _, ss]] = self.covariance;
        let bearing = bb + reach * (2.0 * br + reach * rr) + wander.max(0.0);
        let with_rate = kept * (br + reach * rr) + variance * reach * reach / memory;
        let with_sway = sway_decay * (bs + reach * rs);
        let rate = kept * kept * rr + variance * (1.0 - kept * kept);
        let rate_with_sway = kept * sway_decay * rs;
        let sway = sway_decay * sway_decay * ss + sway_variance * (1.0 - sway_decay * sway_decay);
        let direction = unit([0, 1, 2].map(|i| self.direction[i] + reach * self.rate[i]));
        Self {
            direction,
            rate: tangential(self.rate.map(|rate| kept * rate), direction),
            sway: tangential(self.sway.map(|sway| sway_decay * sway), direction),
            covariance: [
                [bearing, with_rate, with_sway],
                [with_rate, rate, rate_with_sway],
                [with_sway, rate_with_sway, sway],
            ],
        }
    }

    /// How far a look lies off, across the line of input.
    fn innovation(&self, look: Direction) -> [f64; 3] {
        let off = tangential(look, self.direction);
        [0, 1, 2].map(|i| off[i] - self.sway[i])
    }

    /// After a look that lies so far off.
    fn updated(&self, off: [f64; 3], look_variance: f64) -> Self {
        let spread = self.variance() + look_variance;
        let innovation = clip_length(off, INNOVATION_GATE * INNOVATION_GATE * spread);
        let with_look = self.covariance.map(|row| row[0] + row[2]);
        let gains = with_look.map(|covariance| covariance / spread);
        let [of_bearing, of_rate, of_sway] = gains;
        let direction = unit([0, 1, 2].map(|i| self.direction[i] + of_bearing * innovation[i]));
        let rate = [0, 1, 2].map(|i| self.rate[i] + of_rate * innovation[i]);
        let sway = [0, 1, 2].map(|i| self.sway[i] + of_sway * innovation[i]);
        Self {
            direction,
            rate: clip_length(tangential(rate, direction), MAX_RATE * MAX_RATE),
            sway: tangential(sway, direction),
            covariance: [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.covariance[i][j] - gains[i] * with_look[j])),
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let scale = 1.0 / libm::sqrt(dot(vector, vector));
    vector.map(|x| scale * x)
}

/// What of a vector lies across a direction.
fn tangential(vector: [f64; 3], direction: Direction) -> [f64; 3] {
    let along = dot(vector, direction);
    [0, 1, 2].map(|i| vector[i] - along * direction[i])
}

/// A vector of at most that squared length.
fn clip_length(vector: [f64; 3], most_squared: f64) -> [f64; 3] {
    let squared = dot(vector, vector);
    if squared <= most_squared {
        return vector;
    }
    let share = libm::sqrt(most_squared / squared);
    vector.map(|x| share * x)
}

/// The filter with what it knows.
#[derive(Debug, Clone, Copy)]
pub struct BearingFilter {
    noise: BearingNoise,
    estimate: Option<(Timestamp, Bearing)>,
    sway_variance: f64,
}

impl BearingFilter {
    /// A filter that has seen nothing.
    pub const fn new(noise: BearingNoise) -> Self {
        Self { noise, estimate: None, sway_variance: 0.0 }
    }

    /// Forgets what it has seen of the target; how much sway there is, is the kite's.
    pub fn reset_target(&mut self) {
        self.estimate = None;
    }

    /// The time of the last look, and the bearing as of then.
    pub const fn estimate(&self) -> Option<&(Timestamp, Bearing)> {
        self.estimate.as_ref()
    }

    /// What becomes of a bearing in so long, unseen.
    pub fn predict(&self, bearing: &Bearing, duration_s: f64) -> Bearing {
        bearing.propagated(&Propagation::new(duration_s, &self.noise), &self.noise, self.sway_variance)
    }

    /// Takes from a look how much sway there is: its squared distance from what was predicted, in two directions, beside
    /// the variance of that prediction, so long after the look before.
    fn update_sway_variance(
        &mut self,
        off_squared: f64,
        predicted: f64,
        &Propagation { duration_s, sway_decay, .. }: &Propagation,
    ) {
        let most = self.noise.max_sway_std_dev * self.noise.max_sway_std_dev;
        let renewed = 1.0 - sway_decay * sway_decay;
        let without = predicted + self.noise.measurement_std_dev * self.noise.measurement_std_dev
            - self.sway_variance * renewed;
        let shown =
            ((0.5 * off_squared - without) / renewed).clamp(-MAX_SWAY_SAMPLE * most, MAX_SWAY_SAMPLE * most);
        let share = duration_s / (SWAY_TIME_CONSTANT_S + duration_s);
        self.sway_variance = (self.sway_variance + share * (shown - self.sway_variance)).clamp(0.0, most);
    }

    /// Takes what a law sees, unless that is only expected; the camera as of the picture. After a long gap it begins anew.
    pub fn observe(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> View {
        let (captured, last) = (input.captured, self.estimate.map_or(input.captured, |(last, _)| last));
        if captured.since(last).max(last.since(captured)).as_secs_f64() > MAX_GAP_S {
            self.reset_target();
        }
        let (pan, tilt) = camera.angles_at(captured);
        let view = View::new(camera.focal_px(captured, input.picture), pan, tilt);
        if input.is_measured {
            self.update(view.unproject(input.percept.position), captured);
        }
        view
    }

    /// A look at `captured` showed the target in this direction. One that is not later than the last tells nothing, nor
    /// does what is no direction.
    pub fn update(&mut self, direction: Direction, captured: Timestamp) {
        if !(0.9..=1.1).contains(&dot(direction, direction)) {
            return;
        }
        let next = match &self.estimate {
            Some((last, _)) if captured <= *last => return,
            Some((last, before)) => {
                let span = Propagation::new(captured.since(*last).as_secs_f64(), &self.noise);
                let expected = before.propagated(&span, &self.noise, self.sway_variance);
                let off = expected.innovation(direction);
                self.update_sway_variance(dot(off, off), expected.variance(), &span);
                expected.updated(off, self.noise.measurement_std_dev * self.noise.measurement_std_dev)
            }
            None => Bearing::from_first_measurement(direction, &self.noise, self.sway_variance),
        };
        self.estimate = Some((captured, next));
    }
}
