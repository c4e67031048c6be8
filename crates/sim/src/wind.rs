//! The wind at a height above the water: mean, turbulence and gusts.
//!
//! Turbulence follows Dryden's model at low altitude (`milf8785c`). With the height h in feet (10 to 1000)
//! and the mean wind W, the vertical length scale is h and the horizontal one `h / (0.177 + 0.000823 h)^1.2`;
//! the standard deviation is 0.1 W vertically and `0.1 W / (0.177 + 0.000823 h)^0.4` horizontally. Each
//! component is an Ornstein-Uhlenbeck process whose time constant is its length scale over the mean wind.
//! This first-order form has the model's deviations and time scales, but not the small overshoot of the
//! transverse spectra. Gusts arrive at random; each is one period of (1 - cos). Not modelled: changes of
//! direction, shear.

use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::sea::Wind;
use crate::tick::{TICK_S, TICKS_PER_SECOND};

/// Feet in a metre.
const FEET: f64 = 1.0 / 0.3048;
/// Mean time between two gusts, seconds.
const GUST_EVERY_S: f64 = 30.0;
/// Range of a gust's strength, m/s, in a wind of [`GUST_AT_MPS`], in proportion to which it grows; and range
/// of its duration, seconds.
const GUST_MPS: (f64, f64) = (2.0, 3.0);
const GUST_S: (f64, f64) = (2.0, 4.0);
const GUST_AT_MPS: f64 = 5.0;
/// Lower bound of the speed with which turbulence is carried past, m/s.
const MIN_ADVECTION_MPS: f64 = 1.0;

/// The wind of a trial at one height.
#[derive(Debug, Clone)]
pub struct TurbulentWind {
    mean: Wind,
    along: OrnsteinUhlenbeckProcess,
    across: OrnsteinUhlenbeckProcess,
    up: OrnsteinUhlenbeckProcess,
    gusts: CounterRng,
    /// The present gust.
    gust: Option<Gust>,
    gustiness: f64,
    now: (f64, f64, f64),
}

/// A gust in progress.
#[derive(Debug, Clone, Copy)]
struct Gust {
    /// Peak, m/s.
    strength: f64,
    age_ticks: u64,
    lasts_ticks: u64,
}

impl Gust {
    /// The gust one tick later; `None` when it is over.
    fn next_tick(self) -> Option<Self> {
        (self.age_ticks < self.lasts_ticks).then(|| Self { age_ticks: self.age_ticks + 1, ..self })
    }
}

impl TurbulentWind {
    /// The wind at a height above the water, metres. `gustiness` is a factor of the rate and the strength of
    /// gusts: 0 for none, nominally 1.
    pub fn new(mean: Wind, height_m: f64, gustiness: f64, seed: u64) -> Self {
        let h = (height_m * FEET).clamp(10.0, 1000.0);
        let shape = 0.177 + 0.000_823 * h;
        let advection_mps = mean.speed_mps.max(MIN_ADVECTION_MPS);
        let vertical = 0.1 * mean.speed_mps;
        let horizontal = OrnsteinUhlenbeck {
            std_dev: vertical / libm::pow(shape, 0.4),
            time_constant_s: h / libm::pow(shape, 1.2) / FEET / advection_mps,
        };
        let upright = OrnsteinUhlenbeck { std_dev: vertical, time_constant_s: h / FEET / advection_mps };
        // Three processes of one stream, with different seeds.
        let process = |model, which: u64| {
            OrnsteinUhlenbeckProcess::new(
                model,
                CounterRng::new(seed.wrapping_add(which << 48), Stream::Wind),
            )
        };
        Self {
            mean,
            along: process(horizontal, 0),
            across: process(horizontal, 1),
            up: process(upright, 2),
            gusts: CounterRng::new(seed, Stream::WindGusts),
            gust: None,
            gustiness,
            now: (0.0, 0.0, 0.0),
        }
    }

    /// Advances by a tick.
    pub fn advance(&mut self, tick: u64) {
        self.along.advance(tick);
        self.across.advance(tick);
        self.up.advance(tick);
        // A gust counts its own ticks, because the world's tick number jumps where the trial begins.
        self.gust = self.gust.and_then(Gust::next_tick);
        if self.gust.is_none() && self.gusts.unit(3 * tick) < self.gustiness * TICK_S / GUST_EVERY_S {
            let strength = self.gustiness * self.gusts.between(3 * tick + 1, GUST_MPS) * self.mean.speed_mps
                / GUST_AT_MPS;
            let lasts_s = self.gusts.between(3 * tick + 2, GUST_S);
            let lasts_ticks = (lasts_s * f64::from(TICKS_PER_SECOND)) as u64;
            self.gust = Some(Gust { strength, age_ticks: 0, lasts_ticks });
        }
        let gust = self.gust.map_or(0.0, |gust| {
            let share = gust.age_ticks as f64 / gust.lasts_ticks.max(1) as f64;
            0.5 * gust.strength * (1.0 - libm::cos(core::f64::consts::TAU * share))
        });
        let (sin, cos) = libm::sincos(self.mean.towards.radians());
        let (along, across) = (self.along.value() + gust, self.across.value());
        self.now = (along * cos - across * sin, along * sin + across * cos, self.up.value());
    }

    /// Difference from the mean wind along the world's x, y and z, m/s.
    pub const fn turbulence(&self) -> (f64, f64, f64) {
        self.now
    }

    /// Wind velocity along the world's x and y, m/s.
    pub fn velocity(&self) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.mean.towards.radians());
        (self.mean.speed_mps * cos + self.now.0, self.mean.speed_mps * sin + self.now.1)
    }
}
