//! Random numbers of a trial: one counter-based stream for each purpose, and processes driven by them.
//!
//! All numbers come from [`crate::noise`] by the trial's seed, one of these streams, and an index that counts
//! ticks or samples. No sample depends on how many others were drawn.

use crate::noise;
use crate::tick::TICK_S;

/// Purpose of a stream. The numbers must not change: a seed stands for the same trial for good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// The vehicle's plant, where it is sampled for each trial.
    Plant = 1,
    /// Offset of the camera's first view.
    FirstView = 2,
    /// Offsets of the way-points.
    WayPoints = 3,
    /// The target's speed over the whole trial, and its times at rest before and after.
    Pace = 4,
    /// Variation of the target's speed.
    SpeedVariation = 5,
    /// Pauses of the target.
    Pauses = 6,
    /// Noise of the localisation, horizontal.
    Sensor = 7,
    /// Yaw of the platform.
    SwayYaw = 8,
    /// Pitch of the platform.
    SwayPitch = 9,
    /// Roll of the platform.
    SwayRoll = 10,
    /// Position of the platform along x.
    SwayX = 11,
    /// Position of the platform along y.
    SwayY = 12,
    /// Position of the platform along z.
    SwayZ = 13,
    /// Turbulence of the wind.
    Wind = 14,
    /// Gusts.
    WindGusts = 15,
    /// The waves.
    Sea = 16,
    /// The camera's electronics.
    Electronics = 17,
    /// Delays and losses of the video.
    VideoLink = 18,
    /// Positions of the objects beside the target.
    Scenery = 19,
    /// Vibration of the gimbal.
    GimbalJitter = 20,
    /// Variation of the target's heading about the direction to its aim.
    Weave = 21,
    /// Noise of the localisation, vertical.
    SensorUpward = 22,
    /// Pauses of the target at corners.
    CornerPauses = 23,
    /// The box that the simulated operator draws.
    Operator = 24,
    /// Losses of the packets of an emulated vehicle's line.
    LinePackets = 25,
    /// Noise of the localised heading.
    SensorHeading = 26,
}

/// A counter-based generator: one stream of a seed ([`barrelman_vocab::rng::hash`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CounterRng {
    seed: u64,
    stream: u64,
}

impl CounterRng {
    /// The generator of a stream.
    pub const fn new(seed: u64, stream: Stream) -> Self {
        Self { seed, stream: stream as u64 }
    }

    /// Sample of the standard normal distribution.
    pub fn normal(self, index: u64) -> f64 {
        noise::normal(self.seed, self.stream, index)
    }

    /// Sample of the exponential distribution of mean 1.
    pub fn exponential(self, index: u64) -> f64 {
        noise::exponential(self.seed, self.stream, index)
    }

    /// Uniform sample in [0, 1).
    pub fn unit(self, index: u64) -> f64 {
        noise::unit(self.seed, self.stream, index)
    }

    /// Uniform sample between two bounds.
    pub fn between(self, index: u64, (low, high): (f64, f64)) -> f64 {
        low + (high - low) * self.unit(index)
    }
}

/// Parameters of an Ornstein-Uhlenbeck process of mean 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OrnsteinUhlenbeck {
    /// Standard deviation, in the unit of the process.
    pub std_dev: f64,
    /// Time constant of the autocorrelation, seconds; 0: white noise.
    pub time_constant_s: f64,
}

/// An Ornstein-Uhlenbeck process in ticks of [`TICK_S`].
#[derive(Debug, Clone, Copy)]
pub struct OrnsteinUhlenbeckProcess {
    rng: CounterRng,
    /// Factor of the value from tick to tick, and standard deviation of what is added.
    keep: f64,
    add: f64,
    value: f64,
}

impl OrnsteinUhlenbeckProcess {
    /// A process whose first value has the full standard deviation.
    pub fn new(model: OrnsteinUhlenbeck, rng: CounterRng) -> Self {
        let keep = libm::exp(-TICK_S / model.time_constant_s);
        let add = model.std_dev * libm::sqrt(1.0 - keep * keep);
        Self { rng, keep, add, value: model.std_dev * rng.normal(0) }
    }

    /// Advances by `tick`, counted from 0.
    pub fn advance(&mut self, tick: u64) {
        if self.add > 0.0 {
            self.value = self.keep * self.value + self.add * self.rng.normal(tick + 1);
        }
    }

    /// Present value.
    pub const fn value(&self) -> f64 {
        self.value
    }
}
