//! The bearing filter: the direction of the target and its rate, in a frame that does not turn with the
//! camera.
//!
//! A Kalman filter on the sphere, with equal variances in both directions across the line of sight. The
//! bearing's rate is an Ornstein-Uhlenbeck process with the time constant
//! [`BearingNoise::rate_time_constant_s`] and the standard deviation [`BearingNoise::rate_std_dev`] in each
//! of the two directions; the bearing is its integral. The sway of the kite, which no command contains, is a
//! second Ornstein-Uhlenbeck process that is added to the bearing. The filter estimates the sway's variance
//! from the innovations. The step length is the time between two pictures. A repeated picture is not a
//! measurement. Without measurements the covariance grows accordingly. Work per step: O(1), no allocation.

use barrelman_vocab::Timestamp;

use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::view::View;

pub use crate::view::Direction;

/// Noise parameters of the target's motion and of its measurement. Standard deviations are per direction, in
/// each of the two directions across the line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingNoise {
    /// Standard deviation of the bearing's rate, rad/s.
    pub rate_std_dev: f64,
    /// Time constant of the rate, seconds.
    pub rate_time_constant_s: f64,
    /// Standard deviation of a measurement without sway, rad.
    pub measurement_std_dev: f64,
    /// Largest standard deviation of the kite's sway, rad. The filter estimates the sway up to this value.
    pub max_sway_std_dev: f64,
    /// Time constant of the sway, seconds.
    pub sway_time_constant_s: f64,
}

/// Symmetric covariance of bearing, rate and sway.
type Covariance = [[f64; 3]; 3];

/// Largest bearing rate of a target, rad/s.
const MAX_RATE: f64 = 1.0;
/// Innovation gate, in standard deviations; larger innovations are clipped to it.
const INNOVATION_GATE: f64 = 4.0;
/// Largest sway variance that one measurement may indicate, as a multiple of the largest sway variance.
const MAX_SWAY_SAMPLE: f64 = 4.0;
/// The filter restarts after this time without a measurement, seconds.
const MAX_GAP_S: f64 = 0.6;
/// Time constant of the estimate of the sway variance, seconds.
const SWAY_TIME_CONSTANT_S: f64 = 2.0;

/// A duration with the decay of rate and sway within it (factors, 0 to 1).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Propagation {
    pub(crate) duration_s: f64,
    pub(crate) rate_decay: f64,
    pub(crate) sway_decay: f64,
}

impl Propagation {
    /// No time.
    pub(crate) const ZERO: Self = Self { duration_s: 0.0, rate_decay: 1.0, sway_decay: 1.0 };

    pub(crate) fn new(duration_s: f64, noise: &BearingNoise) -> Self {
        Self {
            duration_s,
            rate_decay: libm::exp(-duration_s / noise.rate_time_constant_s),
            sway_decay: libm::exp(-duration_s / noise.sway_time_constant_s),
        }
    }

    /// This propagation followed by another one.
    pub(crate) fn then(&self, next: &Self) -> Self {
        Self {
            duration_s: self.duration_s + next.duration_s,
            rate_decay: self.rate_decay * next.rate_decay,
            sway_decay: self.sway_decay * next.sway_decay,
        }
    }
}

/// The estimate of the filter: bearing, rate and sway with their covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// Direction of the target without sway.
    direction: Direction,
    /// Rate of the direction, 1/s; perpendicular to the direction.
    rate: [f64; 3],
    /// Offset of the direction due to sway; perpendicular to the direction.
    sway: [f64; 3],
    covariance: Covariance,
}

impl Bearing {
    /// The estimate after the first measurement, which contains the bearing and the sway.
    fn from_first_measurement(direction: Direction, noise: &BearingNoise, sway_variance: f64) -> Self {
        let mut covariance = [[0.0; 3]; 3];
        covariance[0][0] = noise.measurement_std_dev * noise.measurement_std_dev + sway_variance;
        covariance[1][1] = noise.rate_std_dev * noise.rate_std_dev;
        covariance[2][2] = sway_variance;
        (covariance[0][2], covariance[2][0]) = (-sway_variance, -sway_variance);
        Self { direction, rate: [0.0; 3], sway: [0.0; 3], covariance }
    }

    /// The direction in which the target is seen, including the sway.
    pub fn apparent_direction(&self) -> Direction {
        unit([0, 1, 2].map(|i| self.direction[i] + self.sway[i]))
    }

    /// Variance of the apparent direction, per direction across the line of sight, rad².
    pub fn variance(&self) -> f64 {
        let [of_bearing, _, of_sway] = self.covariance;
        of_bearing[0] + 2.0 * of_bearing[2] + of_sway[2]
    }

    /// The direction of the target without sway.
    pub(crate) const fn direction(&self) -> Direction {
        self.direction
    }

    /// The predicted apparent direction: `rate_gain_s` is the change of the bearing per unit of rate, in
    /// seconds, and `sway_decay` the decay of the sway. The result is slightly longer than a unit vector.
    pub(crate) fn apparent_direction_after(&self, rate_gain_s: f64, sway_decay: f64) -> Direction {
        [0, 1, 2].map(|i| self.direction[i] + rate_gain_s * self.rate[i] + sway_decay * self.sway[i])
    }

    /// Standard deviation of the predicted apparent direction that is added by rate and sway, rad.
    pub(crate) fn predicted_std_dev(&self, rate_gain_s: f64, sway_decay: f64) -> f64 {
        let row = [1.0, rate_gain_s, sway_decay];
        let variance: f64 =
            (0..3).map(|i| (0..3).map(|j| row[i] * row[j] * self.covariance[i][j]).sum::<f64>()).sum();
        libm::sqrt((variance - self.variance()).max(0.0))
    }

    /// Magnitude of the bearing's rate, rad/s.
    pub fn angular_speed(&self) -> f64 {
        libm::sqrt(dot(self.rate, self.rate))
    }

    /// The estimate after a duration without measurements (the prediction step of the filter).
    fn propagated(&self, over: &Propagation, noise: &BearingNoise, sway_variance: f64) -> Self {
        let Propagation { duration_s, rate_decay: decay, sway_decay } = *over;
        let time_constant_s = noise.rate_time_constant_s;
        let gain_s = time_constant_s * (1.0 - decay);
        let variance = noise.rate_std_dev * noise.rate_std_dev;
        let added =
            variance * time_constant_s * (2.0 * duration_s - time_constant_s * (3.0 - decay * (4.0 - decay)));
        let [[bb, br, bs], [_, rr, rs], [_, _, ss]] = self.covariance;
        let bearing = bb + gain_s * (2.0 * br + gain_s * rr) + added.max(0.0);
        let with_rate = decay * (br + gain_s * rr) + variance * gain_s * gain_s / time_constant_s;
        let with_sway = sway_decay * (bs + gain_s * rs);
        let rate = decay * decay * rr + variance * (1.0 - decay * decay);
        let rate_with_sway = decay * sway_decay * rs;
        let sway = sway_decay * sway_decay * ss + sway_variance * (1.0 - sway_decay * sway_decay);
        let direction = unit([0, 1, 2].map(|i| self.direction[i] + gain_s * self.rate[i]));
        Self {
            direction,
            rate: perpendicular(self.rate.map(|rate| decay * rate), direction),
            sway: perpendicular(self.sway.map(|sway| sway_decay * sway), direction),
            covariance: [
                [bearing, with_rate, with_sway],
                [with_rate, rate, rate_with_sway],
                [with_sway, rate_with_sway, sway],
            ],
        }
    }

    /// The innovation of a measurement, perpendicular to the line of sight.
    fn innovation(&self, measured: Direction) -> [f64; 3] {
        let off = perpendicular(measured, self.direction);
        [0, 1, 2].map(|i| off[i] - self.sway[i])
    }

    /// The estimate after a measurement with this innovation (the update step of the filter).
    fn updated(&self, innovation: [f64; 3], measurement_variance: f64) -> Self {
        let innovation_variance = self.variance() + measurement_variance;
        let innovation = clip_length(innovation, INNOVATION_GATE * INNOVATION_GATE * innovation_variance);
        let with_measurement = self.covariance.map(|row| row[0] + row[2]);
        let gains = with_measurement.map(|covariance| covariance / innovation_variance);
        let [of_bearing, of_rate, of_sway] = gains;
        let direction = unit([0, 1, 2].map(|i| self.direction[i] + of_bearing * innovation[i]));
        let rate = [0, 1, 2].map(|i| self.rate[i] + of_rate * innovation[i]);
        let sway = [0, 1, 2].map(|i| self.sway[i] + of_sway * innovation[i]);
        let covariance =
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.covariance[i][j] - gains[i] * with_measurement[j]));
        Self {
            direction,
            rate: clip_length(perpendicular(rate, direction), MAX_RATE * MAX_RATE),
            sway: perpendicular(sway, direction),
            covariance,
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

/// The component of a vector that is perpendicular to a direction.
fn perpendicular(vector: [f64; 3], direction: Direction) -> [f64; 3] {
    let along = dot(vector, direction);
    [0, 1, 2].map(|i| vector[i] - along * direction[i])
}

/// The vector, shortened if its squared length exceeds `max_squared`.
fn clip_length(vector: [f64; 3], max_squared: f64) -> [f64; 3] {
    let squared = dot(vector, vector);
    if squared <= max_squared {
        return vector;
    }
    let share = libm::sqrt(max_squared / squared);
    vector.map(|x| share * x)
}

/// The filter with its estimate.
#[derive(Debug, Clone, Copy)]
pub struct BearingFilter {
    noise: BearingNoise,
    estimate: Option<(Timestamp, Bearing)>,
    sway_variance: f64,
}

impl BearingFilter {
    /// A filter without measurements.
    pub const fn new(noise: BearingNoise) -> Self {
        Self { noise, estimate: None, sway_variance: 0.0 }
    }

    /// Discards the estimate of the target. The sway variance is kept: it belongs to the kite.
    pub fn reset_target(&mut self) {
        self.estimate = None;
    }

    /// The time of the last measurement, and the estimate at that time.
    pub const fn estimate(&self) -> Option<&(Timestamp, Bearing)> {
        self.estimate.as_ref()
    }

    /// Estimated standard deviation of the sway, per direction across the line of sight, rad.
    pub(crate) fn sway_std_dev(&self) -> f64 {
        libm::sqrt(self.sway_variance)
    }

    /// The estimate after a duration without measurements.
    pub fn predict(&self, bearing: &Bearing, duration_s: f64) -> Bearing {
        bearing.propagated(&Propagation::new(duration_s, &self.noise), &self.noise, self.sway_variance)
    }

    /// Updates the sway variance from an innovation, given the predicted variance of the apparent direction.
    /// The squared innovation is the sum of two directions.
    fn update_sway_variance(
        &mut self,
        innovation_squared: f64,
        predicted_variance: f64,
        &Propagation { duration_s, sway_decay, .. }: &Propagation,
    ) {
        let max_variance = self.noise.max_sway_std_dev * self.noise.max_sway_std_dev;
        let max_sample = MAX_SWAY_SAMPLE * max_variance;
        let renewed = 1.0 - sway_decay * sway_decay;
        let without_sway = predicted_variance
            + self.noise.measurement_std_dev * self.noise.measurement_std_dev
            - self.sway_variance * renewed;
        let sample = ((0.5 * innovation_squared - without_sway) / renewed).clamp(-max_sample, max_sample);
        let share = duration_s / (SWAY_TIME_CONSTANT_S + duration_s);
        self.sway_variance =
            (self.sway_variance + share * (sample - self.sway_variance)).clamp(0.0, max_variance);
    }

    /// Processes the input of a law and returns the camera's view at the time of capture. The filter is
    /// updated if the target was measured. It restarts after a gap of more than 0.6 s.
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

    /// Updates the filter with a direction that was measured at `captured`. The filter ignores a measurement
    /// that is not later than the last one, and a vector whose length is not close to 1.
    pub fn update(&mut self, direction: Direction, captured: Timestamp) {
        if !(0.9..=1.1).contains(&dot(direction, direction)) {
            return;
        }
        let next = match &self.estimate {
            Some((last, _)) if captured <= *last => return,
            Some((last, before)) => {
                let interval = Propagation::new(captured.since(*last).as_secs_f64(), &self.noise);
                let expected = before.propagated(&interval, &self.noise, self.sway_variance);
                let innovation = expected.innovation(direction);
                self.update_sway_variance(dot(innovation, innovation), expected.variance(), &interval);
                expected.updated(innovation, self.noise.measurement_std_dev * self.noise.measurement_std_dev)
            }
            None => Bearing::from_first_measurement(direction, &self.noise, self.sway_variance),
        };
        self.estimate = Some((captured, next));
    }
}
