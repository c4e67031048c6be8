//! From light to samples: lens softness, motion blur, exposure and white balance, vignetting, tone curve,
//! noise, and planar YUV 4:2:0 by BT.709 in limited range.
//!
//! *Motion blur* is the mean of up to 12 taps along the motion of the picture during the exposure; the motion
//! is the same for the whole picture and comes from the turning of the camera only. *Noise* is Gaussian with
//! standard deviation `1.2 + 0.012 Y` (8 bit), read from a table at a position given by a hash of seed, tick
//! and row.

use barrelman_simd::{Simd, multiversion};
use barrelman_vocab::video::{ColourMatrix, LumaWeights};

use super::texture::ROUNDING;
use crate::noise;

const WEIGHTS: LumaWeights = ColourMatrix::Bt709.luma_weights();
const RED: f32 = WEIGHTS.red as f32;
const GREEN: f32 = WEIGHTS.green as f32;
const BLUE: f32 = WEIGHTS.blue as f32;
const CB_DIVISOR: f32 = WEIGHTS.cb_divisor() as f32;
const CR_DIVISOR: f32 = WEIGHTS.cr_divisor() as f32;

/// Size of the noise table.
const TABLE: usize = 1 << 16;
/// Upper bound of the motion blur's taps.
pub(super) const MAX_TAPS: usize = 12;

/// Gaussian numbers of standard deviation 1.
#[derive(Debug)]
pub(super) struct NoiseTable(Vec<f32>);

impl NoiseTable {
    pub(super) fn new(seed: u64) -> Self {
        let gauss = |at: usize| {
            let u = noise::unit(seed, 0x6A, at as u64);
            let radius = libm::sqrt(-2.0 * libm::log(u.max(1e-12)));
            (radius * libm::cos(core::f64::consts::TAU * noise::unit(seed, 0x6B, at as u64))) as f32
        };
        Self((0..TABLE).map(gauss).collect())
    }

    /// Numbers for a row of pixels, from a position given by a hash.
    pub(super) fn row(&self, random: u64, width: usize) -> &[f32] {
        &self.0[random as usize % (TABLE - width)..][..width]
    }
}

/// How a row of light becomes samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Development {
    /// Gains of red, green and blue.
    pub(super) gains: [f32; 3],
    /// Vertical distance of the row, and horizontal distance of its first pixel, from the centre over half
    /// the diagonal; step from pixel to pixel.
    pub(super) y: f32,
    pub(super) x0: f32,
    pub(super) step: f32,
    /// 1 with noise, 0 without.
    pub(super) noise: f32,
}

/// Loss of brightness in the corners.
const VIGNETTE: f32 = 0.30;

multiversion! { simd;
    /// Turns linear light into display values, 0 to 1, in place.
    pub(super) fn develop(simd: Simd, how: &Development, row: [&mut [f32]; 3]) {
        for (c, channel) in row.into_iter().enumerate() {
            for (i, value) in channel.iter_mut().enumerate() {
                let x = how.x0 + i as i32 as f32 * how.step;
                let off = x * x + how.y * how.y;
                let light = (*value * how.gains[c] * (1.0 - VIGNETTE * off)).max(0.0);
                // A filmic curve: a toe, a nearly straight middle, a shoulder.
                let toned = light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14);
                *value = toned.min(1.0).sqrt();
            }
        }
    }
}

multiversion! { simd;
    /// Luma of one row.
    pub(super) fn luma(simd: Simd, how: &Development, rgb: [&[f32]; 3], noise: &[f32], out: &mut [u8]) {
        let [r, g, b] = rgb;
        let width = out.len();
        let (r, g, b, noise) = (&r[..width], &g[..width], &b[..width], &noise[..width]);
        for i in 0..width {
            let y = 16.0 + 219.0 * (RED * r[i] + GREEN * g[i] + BLUE * b[i]);
            let y = y + how.noise * noise[i] * (1.2 + 0.012 * y);
            out[i] = (y.max(16.0).min(235.0) + ROUNDING).to_bits() as u8;
        }
    }
}

multiversion! { simd;
    /// Chroma of two rows, the mean of 2 x 2 pixels. `sums` holds the rows' red, green and blue, summed.
    pub(super) fn chroma(
        simd: Simd,
        how: &Development,
        sums: [&[f32]; 3],
        noise: [&[f32]; 2],
        u: &mut [u8],
        v: &mut [u8],
    ) {
        let width = u.len().min(v.len());
        let [r, g, b] = sums;
        let (r, g, b) = (&r[..2 * width], &g[..2 * width], &b[..2 * width]);
        let (nu, nv) = (&noise[0][..width], &noise[1][..width]);
        for i in 0..width {
            let mean = |s: &[f32]| 0.25 * (s[2 * i] + s[2 * i + 1]);
            let (r, g, b) = (mean(r), mean(g), mean(b));
            let y = RED * r + GREEN * g + BLUE * b;
            let strength = how.noise * (0.7 + 1.2 * y);
            let blue = 128.0 + (224.0 / CB_DIVISOR) * (b - y) + strength * nu[i];
            let red = 128.0 + (224.0 / CR_DIVISOR) * (r - y) + strength * nv[i];
            u[i] = (blue.max(16.0).min(240.0) + ROUNDING).to_bits() as u8;
            v[i] = (red.max(16.0).min(240.0) + ROUNDING).to_bits() as u8;
        }
    }
}

multiversion! { simd;
    /// Adds `weight` times a row to `out`: `out[i]` takes `from[i + shift]`; the border repeats.
    pub(super) fn add_shifted(simd: Simd, from: &[f32], shift: i32, weight: f32, out: &mut [f32]) {
        let width = out.len();
        let from = &from[..width];
        let start = (-shift).clamp(0, width as i32) as usize;
        let end = (width as i32 - shift).clamp(0, width as i32) as usize;
        for i in 0..start {
            out[i] += weight * from[0];
        }
        if start < end {
            let source = &from[(start as i32 + shift) as usize..(end as i32 + shift) as usize];
            for (slot, value) in out[start..end].iter_mut().zip(source) {
                *slot += weight * value;
            }
        }
        for i in end.max(start)..width {
            out[i] += weight * from[width - 1];
        }
    }
}

multiversion! { simd;
    /// Softness of the lens: weights `side`, 1 - 2 `side`, `side` across the rows, then along the row.
    pub(super) fn soften(
        simd: Simd,
        rows: [&[f32]; 3],
        side: f32,
        scratch: &mut [f32],
        out: &mut [f32],
    ) {
        let width = out.len();
        let [up, here, down] = rows;
        let (up, here, down) = (&up[..width], &here[..width], &down[..width]);
        let scratch = &mut scratch[..width];
        let centre = 1.0 - 2.0 * side;
        for i in 0..width {
            scratch[i] = centre * here[i] + side * (up[i] + down[i]);
        }
        for i in 1..width - 1 {
            out[i] = centre * scratch[i] + side * (scratch[i - 1] + scratch[i + 1]);
        }
        out[0] = (1.0 - side) * scratch[0] + side * scratch[1];
        out[width - 1] = (1.0 - side) * scratch[width - 1] + side * scratch[width - 2];
    }
}
