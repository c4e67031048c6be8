//! Periodic tiles of waves, and how they are mapped into a picture.
//!
//! A tile is a sum of plane waves with whole numbers of cycles per tile, directions spread about the wind's,
//! and amplitudes that fall with the wave number: h(x) = sum a_k cos(2 pi k.x / N + phase_k), scaled to mean
//! 0 and variance 1.

use barrelman_vocab::rng::SplitMix64;

use super::view::View;

/// Texels per side: a power of two, so that positions wrap.
pub(super) const SIDE: usize = 512;
/// Bits of a position below the texel index: positions are fractions of the tile in 32 bits.
const FRACTION_BITS: u32 = 32 - SIDE.trailing_zeros();

/// Parameters of a tile's waves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spectrum {
    /// Number of plane waves.
    pub(super) waves: usize,
    /// Cycles per tile, lowest and highest.
    pub(super) cycles: (f64, f64),
    /// Mean direction of travel in the plane, radians.
    pub(super) direction: f64,
    /// Standard deviation of the direction, radians.
    pub(super) spread: f64,
}

#[derive(Debug, Clone)]
pub(super) struct Tile {
    samples: Vec<f32>,
}

impl Tile {
    pub(super) fn new(spectrum: Spectrum, mut rng: SplitMix64) -> Self {
        let mut samples = vec![0.0_f32; SIDE * SIDE];
        let turn = core::f64::consts::TAU / SIDE as f64;
        let table: Vec<(f32, f32)> = (0..SIDE)
            .map(|at| (libm::cos(turn * at as f64) as f32, libm::sin(turn * at as f64) as f32))
            .collect();
        let (low, high) = spectrum.cycles;
        for _ in 0..spectrum.waves {
            let cycles = low * libm::pow(high / low, rng.uniform());
            let direction = spectrum.direction + spectrum.spread * rng.approximately_normal();
            let kx = (cycles * libm::cos(direction)).round() as i64;
            let ky = (cycles * libm::sin(direction)).round() as i64;
            if kx == 0 && ky == 0 {
                continue;
            }
            let height = libm::pow(cycles, -0.6) as f32;
            let phase = (rng.uniform() * SIDE as f64) as i64;
            for (row, line) in samples.chunks_exact_mut(SIDE).enumerate() {
                let (c, s) = table[(ky * row as i64 + phase).rem_euclid(SIDE as i64) as usize];
                let (c, s) = (c * height, s * height);
                let mut at = 0_i64;
                for sample in line {
                    let (cx, sx) = table[(at & (SIDE as i64 - 1)) as usize];
                    *sample += c * cx - s * sx;
                    at += kx;
                }
            }
        }
        let square: f64 = samples.iter().map(|sample| f64::from(*sample) * f64::from(*sample)).sum();
        let scale = (1.0 / libm::sqrt((square / samples.len() as f64).max(1e-12))) as f32;
        samples.iter_mut().for_each(|sample| *sample *= scale);
        Self { samples }
    }
}

/// A tile mapped onto the plane: its scale and its drift.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layer {
    /// Units of the plane per texel.
    pub(super) scale: f64,
    /// Units of the plane per second.
    pub(super) drift: (f64, f64),
    /// Texels, so that layers of one tile do not coincide.
    pub(super) offset: (f64, f64),
}

/// A layer in one picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct LayerView<'a> {
    tile: &'a Tile,
    start: (f64, f64),
    step: (f64, f64),
}

impl Layer {
    /// The layer in a picture. `first`: picture coordinates of the first sample's middle.
    pub(super) fn view_from<'a>(
        &self,
        tile: &'a Tile,
        view: &View,
        time_s: f64,
        first: (f64, f64),
    ) -> LayerView<'a> {
        let at = view.plane(first.0, first.1);
        let texel = |at: f64, drift: f64, offset: f64| (at - drift * time_s) / self.scale + offset;
        // Rows of the tile run towards the camera's far side, as the plane's y does.
        let start = (texel(at.x, self.drift.0, self.offset.0), texel(at.y, self.drift.1, self.offset.1));
        let (step_x, step_y) = view.plane_offset(1.0, 1.0);
        LayerView { tile, start, step: (step_x / self.scale, step_y / self.scale) }
    }
}

impl LayerView<'_> {
    /// Interpolates one row of the picture linearly between the texels; `scratch` is overwritten.
    pub(super) fn row(&self, row: usize, scratch: &mut [f32; SIDE + 1], out: &mut [f32]) {
        let y = to_tile_fraction(self.start.1 + self.step.1 * row as f64);
        let (upper, share) = split_position(y);
        let lower = (upper + 1) % SIDE;
        let upper = &self.tile.samples[upper * SIDE..][..SIDE];
        let lower = &self.tile.samples[lower * SIDE..][..SIDE];
        for ((mixed, a), b) in scratch.iter_mut().zip(upper).zip(lower) {
            *mixed = a + (b - a) * share;
        }
        scratch[SIDE] = scratch[0];
        let mut x = to_tile_fraction(self.start.0);
        let step = to_tile_fraction(self.step.0);
        for sample in out {
            let (at, share) = split_position(x);
            *sample = scratch[at] + (scratch[at + 1] - scratch[at]) * share;
            x = x.wrapping_add(step);
        }
    }
}

/// A position in texels as a fraction of the tile, modulo the tile.
fn to_tile_fraction(texels: f64) -> u32 {
    let share = texels / SIDE as f64;
    ((share - share.floor()) * 4_294_967_296.0) as u64 as u32
}

fn split_position(position: u32) -> (usize, f32) {
    let share = (position & ((1 << FRACTION_BITS) - 1)) as f32 / (1_u32 << FRACTION_BITS) as f32;
    ((position >> FRACTION_BITS) as usize, share)
}
