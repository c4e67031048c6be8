//! The bearing filter: in what direction the target is and how fast that turns, in a frame that does not turn with the
//! camera.
//!
//! A Kalman filter on the sphere, the same in every direction across the line of sight: the rate is an
//! Ornstein-Uhlenbeck process (it keeps its value for about [`BearingNoise::memory_s`] and has the deviation
//! [`BearingNoise::rate`] in each of two directions), the bearing its integral, and a look measures the bearing with the
//! deviation [`BearingNoise::look`], in which the kite's own sway is counted that the camera's model does not know: how
//! far looks lie from what was predicted says how much that is, and in wind the filter smooths more. Steps are as long as the pictures are apart; a picture that comes again is no look; through a gap the covariance
//! grows as it should. O(1), no allocation.

use barrelman_vocab::Timestamp;

pub use crate::view::Direction;

/// How a target's bearing turns and how well it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingNoise {
    /// Deviation of the bearing's rate, rad/s, in each of two directions across the line of sight.
    pub rate: f64,
    /// How long the rate keeps its value, seconds.
    pub memory_s: f64,
    /// Deviation of a look where nothing sways, rad, in each of two directions.
    pub look: f64,
    /// The most that it is taken to be: between the two it follows what the looks themselves show.
    pub worst_look: f64,
}

/// A bearing, how fast it turns, and how well both are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// Where the target is.
    pub direction: Direction,
    /// How the direction changes, 1/s; across the direction.
    pub rate: [f64; 3],
    /// Variance of the direction across the line of sight, rad².
    pub variance: f64,
    /// Its covariance with the rate, rad²/s.
    pub covariance: f64,
    /// Variance of the rate, rad²/s².
    pub rate_variance: f64,
}

/// Rates beyond this are no target's, rad/s.
const FASTEST: f64 = 1.0;
/// Innovations beyond so many deviations are taken for so many: a jump of the tracker counts for less.
const FARTHEST: f64 = 4.0;
/// By what share of a surprise the deviation of a look is corrected.
const LEARNING_SHARE: f64 = 0.015;

impl Bearing {
    /// After a first look.
    fn first(direction: Direction, noise: &BearingNoise) -> Self {
        Self {
            direction,
            rate: [0.0; 3],
            variance: noise.look * noise.look,
            covariance: 0.0,
            rate_variance: noise.rate * noise.rate,
        }
    }

    /// Where the target is after its rate has gone on for so long; `reach_s` is that time less what is lost as the rate
    /// fades.
    pub(crate) fn direction_after(&self, reach_s: f64) -> Direction {
        unit([0, 1, 2].map(|i| self.direction[i] + reach_s * self.rate[i]))
    }

    /// How fast the bearing turns, rad/s.
    pub fn speed(&self) -> f64 {
        libm::sqrt(dot(self.rate, self.rate))
    }

    /// `span_s` later, unseen.
    pub fn after(&self, span_s: f64, noise: &BearingNoise) -> Self {
        let memory = noise.memory_s;
        let kept = libm::exp(-span_s / memory);
        let reach = memory * (1.0 - kept);
        let variance = noise.rate * noise.rate;
        let wander = variance * memory * (2.0 * span_s - memory * (3.0 - kept * (4.0 - kept)));
        let direction = self.direction_after(reach);
        Self {
            direction,
            rate: across(self.rate.map(|rate| kept * rate), direction),
            variance: self.variance
                + reach * (2.0 * self.covariance + reach * self.rate_variance)
                + wander.max(0.0),
            covariance: kept * (self.covariance + reach * self.rate_variance)
                + variance * reach * reach / memory,
            rate_variance: kept * kept * self.rate_variance + variance * (1.0 - kept * kept),
        }
    }

    /// How far a look lies off, across the line of sight.
    fn off(&self, look: Direction) -> [f64; 3] {
        across([0, 1, 2].map(|i| look[i] - self.direction[i]), self.direction)
    }

    /// After a look that lies so far off.
    fn seen(&self, off: [f64; 3], look_variance: f64) -> Self {
        let spread = self.variance + look_variance;
        let innovation = shortened(off, FARTHEST * libm::sqrt(spread));
        let (gain, rate_gain) = (self.variance / spread, self.covariance / spread);
        let direction = unit([0, 1, 2].map(|i| self.direction[i] + gain * innovation[i]));
        let rate = [0, 1, 2].map(|i| self.rate[i] + rate_gain * innovation[i]);
        Self {
            direction,
            rate: shortened(across(rate, direction), FASTEST),
            variance: (1.0 - gain) * self.variance,
            covariance: (1.0 - gain) * self.covariance,
            rate_variance: self.rate_variance - rate_gain * self.covariance,
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = libm::sqrt(dot(vector, vector));
    vector.map(|x| x / length)
}

/// What of a vector lies across a direction.
fn across(vector: [f64; 3], direction: Direction) -> [f64; 3] {
    let along = dot(vector, direction);
    [0, 1, 2].map(|i| vector[i] - along * direction[i])
}

/// A vector of at most that length.
fn shortened(vector: [f64; 3], most: f64) -> [f64; 3] {
    let squared = dot(vector, vector);
    if squared <= most * most {
        return vector;
    }
    let share = most / libm::sqrt(squared);
    vector.map(|x| share * x)
}

/// The filter with what it knows.
#[derive(Debug, Clone)]
pub struct BearingFilter {
    noise: BearingNoise,
    known: Option<(Timestamp, Bearing)>,
    look_variance: f64,
}

impl BearingFilter {
    /// A filter that has seen nothing.
    pub const fn new(noise: BearingNoise) -> Self {
        Self { known: None, look_variance: noise.look * noise.look, noise }
    }

    /// Forgets what it has seen.
    pub fn forget(&mut self) {
        self.known = None;
    }

    /// The time of the last look, and the bearing as of then.
    pub const fn known(&self) -> Option<&(Timestamp, Bearing)> {
        self.known.as_ref()
    }

    /// Takes from a look how well looks show the target: its squared distance from what was predicted, in two
    /// directions, and the variance of the prediction.
    fn learn(&mut self, off_squared: f64, predicted: f64) {
        let (best, worst) =
            (self.noise.look * self.noise.look, self.noise.worst_look * self.noise.worst_look);
        let shown = (0.5 * off_squared - predicted).clamp(0.0, FARTHEST * FARTHEST * worst);
        self.look_variance += LEARNING_SHARE * (shown - self.look_variance);
        self.look_variance = self.look_variance.clamp(best, worst.max(best));
    }

    /// A look at `captured` showed the target in this direction. One that is not later than the last tells nothing.
    pub fn look(&mut self, direction: Direction, captured: Timestamp) {
        if !direction.iter().all(|x| x.is_finite()) {
            return;
        }
        let next = match &self.known {
            Some((last, _)) if captured <= *last => return,
            Some((last, before)) => {
                let span_s = captured.since(*last).as_secs_f64();
                let expected = before.after(span_s, &self.noise);
                let off = expected.off(direction);
                let next = expected.seen(off, self.look_variance);
                self.learn(dot(off, off), expected.variance);
                next
            }
            None => Bearing::first(direction, &self.noise),
        };
        self.known = Some((captured, next));
    }
}
