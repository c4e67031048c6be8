//! The wind at a place above the water: a mean, turbulence and gusts.
//!
//! Turbulence is Dryden's at low altitude (`milf8785c`): with h the height in feet (10 to 1000) and W the mean wind,
//! the vertical length scale is h, the horizontal one `h / (0.177 + 0.000823 h)^1.2`; the vertical deviation is
//! 0.1 W, the horizontal one `0.1 W / (0.177 + 0.000823 h)^0.4`. Each component is an Ornstein-Uhlenbeck process of
//! its length over the mean wind: the first-order form for all three, which has the deviations and the time scales
//! and lacks the small overshoot of the transverse spectra.
//! Gusts come by chance, each a whole period of (1 - cos). What is not in here: direction changes, shear.

use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::sea::Wind;
use crate::tick::{TICK_S, TICKS_PER_SECOND};

/// Feet in a metre.
const FEET: f64 = 1.0 / 0.3048;
/// Mean time between two gusts, seconds.
const GUST_EVERY_S: f64 = 30.0;
/// Bounds of a gust's strength, m/s, and of its duration, seconds, in a wind of 5 m/s; the strength grows with it.
const GUST_MPS: (f64, f64) = (2.0, 3.0);
const GUST_S: (f64, f64) = (2.0, 4.0);
const GUST_AT_MPS: f64 = 5.0;
/// The slowest wind that turbulence is carried by, m/s.
const MIN_ADVECTION_MPS: f64 = 1.0;

/// The wind of a trial at one height.
#[derive(Debug, Clone)]
pub struct TurbulentWind {
    mean: Wind,
    along: OrnsteinUhlenbeckProcess,
    across: OrnsteinUhlenbeckProcess,
    up: OrnsteinUhlenbeckProcess,
    gusts: CounterRng,
    /// The gust that blows.
    gust: Option<Gust>,
    gustiness: f64,
    now: (f64, f64, f64),
}

/// A gust under way.
#[derive(Debug, Clone, Copy)]
struct Gust {
    /// m/s.
    strength: f64,
    age_ticks: u64,
    lasts_ticks: u64,
}

impl Gust {
    /// A tick later; `None` where it is over.
    fn later(self) -> Option<Self> {
        (self.age_ticks < self.lasts_ticks).then(|| Self { age_ticks: self.age_ticks + 1, ..self })
    }
}

impl TurbulentWind {
    /// The wind at a height above the water, metres. `gustiness` multiplies how often gusts come and how strong they
    /// are: 0 for none, 1 as usual.
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
        // Three processes of one stream, told apart by the seed.
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

    /// Advances through a tick.
    pub fn advance(&mut self, tick: u64) {
        self.along.advance(tick);
        self.across.advance(tick);
        self.up.advance(tick);
        // A gust counts its own ticks: the world's begin anew where a trial begins, and it may blow across that.
        self.gust = self.gust.and_then(Gust::later);
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

    /// What it differs from its mean by, along the world's x, y and z, m/s.
    pub const fn turbulence(&self) -> (f64, f64, f64) {
        self.now
    }

    /// Its velocity along the world's x and y, m/s.
    pub fn velocity(&self) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.mean.towards.radians());
        (self.mean.speed_mps * cos + self.now.0, self.mean.speed_mps * sin + self.now.1)
    }
}
