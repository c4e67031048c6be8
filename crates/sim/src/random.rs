//! The streams of chance of a trial, and what wanders with them.
//!
//! Everything random in a world is drawn by [`crate::noise`] from the trial's seed, one of these streams, and a
//! number that counts ticks or draws: no draw depends on how many others were made.

use crate::noise;
use crate::tick::TICK_S;

/// What a draw is for. The numbers must stay: a seed means the same trial for good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// The vehicle's plant, where it is drawn for each trial.
    Plant = 1,
    /// Where the camera looks at first.
    FirstView = 2,
    /// The path's way-points.
    WayPoints = 3,
    /// The target's speed over the whole trial, and how long it stands before and after.
    Pace = 4,
    /// How its speed varies.
    SpeedVariation = 5,
    /// When it pauses.
    Pauses = 6,
    /// The localisation's noise, across.
    Sensor = 7,
    /// The kite's yaw.
    SwayYaw = 8,
    /// Its pitch.
    SwayPitch = 9,
    /// Its roll.
    SwayRoll = 10,
    /// Its place: x, y and z.
    SwayX = 11,
    /// See `SwayX`.
    SwayY = 12,
    /// See `SwayX`.
    SwayZ = 13,
    /// Turbulence of the wind.
    Wind = 14,
    /// Gusts.
    WindGusts = 15,
    /// The waves.
    Sea = 16,
    /// The camera's electronics.
    Electronics = 17,
    /// What befalls the video on its way.
    VideoLink = 18,
    /// Everything that is drawn, and not moved.
    Scenery = 19,
    /// The gimbal's shiver.
    GimbalJitter = 20,
    /// How the target's heading weaves about where it means to go.
    Weave = 21,
    /// The localisation's noise, up and down.
    SensorUpward = 22,
    /// At which corners the target pauses, and how long.
    CornerPauses = 23,
}

/// A seed with one of its streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CounterRng {
    seed: u64,
    stream: u64,
}

impl CounterRng {
    /// The draws of a stream.
    pub const fn new(seed: u64, stream: Stream) -> Self {
        Self { seed, stream: stream as u64 }
    }

    /// From the standard normal distribution.
    pub fn normal(self, index: u64) -> f64 {
        noise::normal(self.seed, self.stream, index)
    }

    /// From the exponential distribution of mean 1.
    pub fn exponential(self, index: u64) -> f64 {
        noise::exponential(self.seed, self.stream, index)
    }

    /// In [0, 1).
    pub fn unit(self, index: u64) -> f64 {
        noise::unit(self.seed, self.stream, index)
    }

    /// Between two bounds.
    pub fn between(self, index: u64, (low, high): (f64, f64)) -> f64 {
        low + (high - low) * self.unit(index)
    }
}

/// How something wanders about its mean: an Ornstein-Uhlenbeck process.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OrnsteinUhlenbeck {
    /// Standard deviation, in the unit of what wanders.
    pub std_dev: f64,
    /// Time after which it has forgotten where it was, seconds; 0: at once.
    pub time_constant_s: f64,
}

/// A wandering value, in ticks of [`TICK_S`].
#[derive(Debug, Clone, Copy)]
pub struct OrnsteinUhlenbeckProcess {
    rng: CounterRng,
    /// What is kept from one tick to the next, and the deviation of what is added.
    keep: f64,
    add: f64,
    value: f64,
}

impl OrnsteinUhlenbeckProcess {
    /// Begins in the middle of its wandering: its first value has the full deviation.
    pub fn new(model: OrnsteinUhlenbeck, rng: CounterRng) -> Self {
        let keep = libm::exp(-TICK_S / model.time_constant_s);
        let add = model.std_dev * libm::sqrt(1.0 - keep * keep);
        Self { rng, keep, add, value: model.std_dev * rng.normal(0) }
    }

    /// Advances through `tick`, counted from 0.
    pub fn advance(&mut self, tick: u64) {
        if self.add > 0.0 {
            self.value = self.keep * self.value + self.add * self.rng.normal(tick + 1);
        }
    }

    /// The value now.
    pub const fn value(&self) -> f64 {
        self.value
    }
}
