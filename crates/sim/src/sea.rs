//! The sea: a sum of travelling waves, the same for the boat that rides it and for the picture that shows it.
//!
//! The elevation of the surface above water at rest is
//!
//! ```text
//! eta(x, y, t) = sum a_i cos(k_i . (x, y) - w_i t + p_i)        w_i^2 = g |k_i|   (deep water)
//! ```
//!
//! with amplitudes a_i (m) from the JONSWAP spectrum of a sea state (`hasselmann1973`), directions spread as
//! cos^4 about the wind, and phases p_i from the seed. The wave vectors k_i (rad/m) lie on the lattice of a
//! square tile, so that a renderer can compute the same surface on a grid by a Fourier transform. The tile's
//! side is eight wavelengths of the spectrum's peak.
//!
//! Phases are `u32` fractions of a turn, and the phase of a wave changes by a whole number of them in each
//! tick: the surface at any tick is exact. Not modelled: ripples shorter than the tile's grid (they do not
//! move a boat; the renderer adds them), breaking, shallow water, and what a current does to the waves: it
//! carries boats and people only.

use barrelman_vocab::Angle;
use barrelman_vocab::rng;

use crate::noise;
use crate::tick::TICKS_PER_SECOND;

/// Gravity, m/s².
const GRAVITY: f64 = 9.81;
/// Peak enhancement factor of the spectrum.
const GAMMA: f64 = 3.3;
/// Wavelengths of the peak along the tile's side.
const PEAK_WAVES: f64 = 8.0;
/// Lowest and highest frequency, in peak frequencies; the highest fits a grid of 128 points.
const BAND: (f64, f64) = (0.6, 2.7);
/// Steps of frequency, and waves for each step.
const STEPS: u64 = 32;
const WAVES_PER_STEP: u64 = 2;

/// Sea state by the World Meteorological Organization's table: 0 (glassy) to 4 (moderate).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SeaState(u8);

/// Significant wave height (m), peak period (s) and associated wind (m/s, 10 m above the water).
const STATES: [(f64, f64, f64); 5] =
    [(0.03, 1.1, 1.5), (0.08, 1.4, 3.0), (0.30, 2.4, 5.0), (0.88, 4.0, 8.0), (1.88, 5.6, 10.5)];

impl SeaState {
    /// All supported states.
    pub const ALL: [Self; 5] = [Self(0), Self(1), Self(2), Self(3), Self(4)];

    /// The state of this number, 0 to 4.
    pub fn new(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// Number of the state.
    pub const fn number(self) -> u8 {
        self.0
    }

    /// Significant wave height, four standard deviations of the elevation, metres.
    pub fn significant_height_m(self) -> f64 {
        STATES[usize::from(self.0)].0
    }

    /// Period of the peak of the spectrum, seconds.
    pub fn peak_period_s(self) -> f64 {
        STATES[usize::from(self.0)].1
    }

    /// Wind that raises such a sea on a short fetch, m/s.
    pub fn wind_mps(self) -> f64 {
        STATES[usize::from(self.0)].2
    }
}

/// Mean wind over the water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wind {
    /// Speed 10 m above the water, m/s.
    pub speed_mps: f64,
    /// Direction the wind blows to: 0 along the world's x, anticlockwise as seen from above.
    pub towards: Angle,
}

/// One travelling wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wave {
    /// Whole wavelengths along the tile's sides.
    pub(crate) lattice: (i32, i32),
    /// Wave vector in the world, rad/m.
    pub(crate) vector: (f64, f64),
    /// Amplitude, metres.
    pub(crate) amplitude: f64,
    /// Angular frequency, rad/s.
    pub(crate) frequency: f64,
    /// Decrease of the phase in a tick, in turns of 2^32.
    pub(crate) rate: u32,
    /// Phase at tick 0 at the world's origin, in turns of 2^32.
    pub(crate) phase: u32,
}

impl Wave {
    /// Phase at a point and a tick, radians.
    pub(crate) fn phase_at(&self, x: f64, y: f64, tick: u64) -> f64 {
        let turns = self.phase.wrapping_sub(self.rate.wrapping_mul(tick as u32));
        f64::from(turns) * RADIANS_PER_TURN + self.vector.0 * x + self.vector.1 * y
    }

    /// Velocity of the water under the crest along x and y, m/s.
    pub(crate) fn crest_velocity(&self) -> (f64, f64) {
        let share = self.amplitude * self.frequency / libm::hypot(self.vector.0, self.vector.1);
        (share * self.vector.0, share * self.vector.1)
    }
}

/// The surface at one point and tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surface {
    /// Elevation above water at rest, metres.
    pub elevation: f64,
    /// Gradient of the elevation along the world's x and y.
    pub slope: (f64, f64),
    /// Velocity of the water at the surface along x, y and z, m/s (orbital motion).
    pub velocity: (f64, f64, f64),
}

/// A sea.
#[derive(Debug, Clone, PartialEq)]
pub struct Sea {
    state: SeaState,
    wind: Wind,
    current: (f64, f64),
    seed: u64,
    side_m: f64,
    waves: Vec<Wave>,
}

impl Sea {
    /// The sea of a state under a wind. Equal arguments give equal waves.
    pub fn new(state: SeaState, wind: Wind, seed: u64) -> Self {
        let peak = core::f64::consts::TAU / state.peak_period_s();
        let peak_length = core::f64::consts::TAU * GRAVITY / (peak * peak);
        let side_m = PEAK_WAVES * peak_length;
        let mut waves: Vec<Wave> = Vec::with_capacity((STEPS * WAVES_PER_STEP) as usize);
        let ratio = libm::pow(BAND.1 / BAND.0, 1.0 / STEPS as f64);
        for step in 0..STEPS {
            let lower = BAND.0 * libm::pow(ratio, step as f64);
            let width = lower * (ratio - 1.0);
            for of_step in 0..WAVES_PER_STEP {
                let index = step * WAVES_PER_STEP + of_step;
                let found = (0..TRIES).find_map(|attempt| {
                    let sample = |stream| noise::unit(seed, stream, index * TRIES + attempt);
                    let relative = lower + width * sample(FREQUENCY);
                    let lattice = lattice_point(
                        relative,
                        wind.towards.radians() + sampled_direction(seed, index, attempt),
                    );
                    let is_taken = waves.iter().any(|wave| wave.lattice == lattice);
                    (lattice != (0, 0) && !is_taken).then_some((lattice, relative))
                });
                if let Some((lattice, relative)) = found {
                    let variance = jonswap(relative) * width / WAVES_PER_STEP as f64;
                    waves.push(wave(lattice, side_m, variance, rng::hash(seed, PHASE, index)));
                }
            }
        }
        let variance: f64 = waves.iter().map(|wave| 0.5 * wave.amplitude * wave.amplitude).sum();
        let std_dev = state.significant_height_m() / 4.0;
        let scale = std_dev / libm::sqrt(variance);
        waves.iter_mut().for_each(|wave| wave.amplitude *= scale);
        Self { state, wind, current: (0.0, 0.0), seed, side_m, waves }
    }

    /// The same sea with a steady current along the world's x and y, m/s.
    #[must_use]
    pub fn with_current(self, current: (f64, f64)) -> Self {
        Self { current, ..self }
    }

    /// Steady current along the world's x and y, m/s.
    pub const fn current(&self) -> (f64, f64) {
        self.current
    }

    /// Mean drift of the water at the surface due to the waves (Stokes drift), along the world's x and y,
    /// m/s: the sum of a² w k over the waves.
    pub fn stokes_drift(&self) -> (f64, f64) {
        self.waves.iter().fold((0.0, 0.0), |(x, y), wave| {
            let share = wave.amplitude * wave.amplitude * wave.frequency;
            (x + share * wave.vector.0, y + share * wave.vector.1)
        })
    }

    /// The surface at a point of the world and a tick.
    pub fn surface_at(&self, x: f64, y: f64, tick: u64) -> Surface {
        let mut surface = Surface::default();
        for wave in &self.waves {
            let turns = wave.phase.wrapping_sub(wave.rate.wrapping_mul(tick as u32));
            let phase = f64::from(turns) * RADIANS_PER_TURN + wave.vector.0 * x + wave.vector.1 * y;
            let (sin, cos) = libm::sincos(phase);
            surface.elevation += wave.amplitude * cos;
            surface.slope.0 -= wave.amplitude * wave.vector.0 * sin;
            surface.slope.1 -= wave.amplitude * wave.vector.1 * sin;
            let speed = wave.amplitude * wave.frequency;
            let length = libm::hypot(wave.vector.0, wave.vector.1);
            surface.velocity.0 += speed * cos * wave.vector.0 / length;
            surface.velocity.1 += speed * cos * wave.vector.1 / length;
            surface.velocity.2 += speed * sin;
        }
        surface
    }

    /// Sea state.
    pub fn state(&self) -> SeaState {
        self.state
    }

    /// Mean wind.
    pub fn wind(&self) -> Wind {
        self.wind
    }

    /// Period of the waves along x and y, metres.
    pub fn tile_side_m(&self) -> f64 {
        self.side_m
    }

    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    pub(crate) fn waves(&self) -> &[Wave] {
        &self.waves
    }
}

/// Streams of random numbers.
const FREQUENCY: u64 = 0x5EA0;
const DIRECTION: u64 = 0x5EA1;
const PHASE: u64 = 0x5EA2;
/// Attempts to find a free lattice point for a wave, and to sample a direction.
const TRIES: u64 = 64;
const RADIANS_PER_TURN: f64 = core::f64::consts::TAU / 4_294_967_296.0;

/// A direction relative to the wind, radians, with density cos^4: sampled by rejection.
fn sampled_direction(seed: u64, index: u64, attempt: u64) -> f64 {
    for round in 0..TRIES {
        let at = ((index * TRIES + attempt) * TRIES + round) * 2;
        let angle = (noise::unit(seed, DIRECTION, at) - 0.5) * core::f64::consts::PI;
        let cos = libm::cos(angle);
        if noise::unit(seed, DIRECTION, at + 1) < cos * cos * cos * cos {
            return angle;
        }
    }
    0.0
}

/// The lattice point nearest to a wave of this frequency (in peak frequencies) and direction (radians from
/// x).
fn lattice_point(relative: f64, direction: f64) -> (i32, i32) {
    let waves = PEAK_WAVES * relative * relative;
    let (sin, cos) = libm::sincos(direction);
    (libm::rint(waves * cos) as i32, libm::rint(waves * sin) as i32)
}

/// The JONSWAP spectrum without its scale, over the frequency in peak frequencies.
fn jonswap(w: f64) -> f64 {
    let s = if w <= 1.0 { 0.07 } else { 0.09 };
    let d = (w - 1.0) / s;
    let w4 = w * w * w * w;
    libm::exp(-1.25 / w4) / (w4 * w) * libm::pow(GAMMA, libm::exp(-0.5 * d * d))
}

fn wave(lattice: (i32, i32), side_m: f64, variance: f64, random: u64) -> Wave {
    let unit = core::f64::consts::TAU / side_m;
    let vector = (unit * f64::from(lattice.0), unit * f64::from(lattice.1));
    let (frequency, rate) = deep_water(libm::hypot(vector.0, vector.1));
    let amplitude = libm::sqrt(2.0 * variance);
    Wave { lattice, vector, amplitude, frequency, rate, phase: (random >> 32) as u32 }
}

/// Angular frequency (rad/s) of a deep-water wave of this wave number (rad/m), and its phase change in a
/// tick, in turns of 2^32.
pub(crate) fn deep_water(wave_number: f64) -> (f64, u32) {
    let exact = libm::sqrt(GRAVITY * wave_number);
    let per_tick = exact / RADIANS_PER_TURN / f64::from(TICKS_PER_SECOND);
    let rate = libm::rint(per_tick) as u32;
    (f64::from(rate) * RADIANS_PER_TURN * f64::from(TICKS_PER_SECOND), rate)
}
