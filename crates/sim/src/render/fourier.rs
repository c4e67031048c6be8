//! The inverse Fourier transform of a square map: from waves on a lattice to the surface on a grid.
//!
//! ```text
//! f(x, y) = sum F(i, j) exp(2 pi i (i x + j y) / n)          n a power of two, no scaling
//! ```
//! Radix-2 Stockham passes over whole rows: each pass reads two rows and writes two, all columns at once,
//! which a compiler turns into vector instructions without changing any sum. A transposition in the middle
//! makes columns rows.

use barrelman_simd::{Simd, multiversion};

/// A complex map of `n` x `n`: real and imaginary parts.
#[derive(Debug, Clone, Default)]
pub(super) struct Map {
    pub(super) re: Vec<f32>,
    pub(super) im: Vec<f32>,
}

impl Map {
    pub(super) fn zeros(n: usize) -> Self {
        Self { re: vec![0.0; n * n], im: vec![0.0; n * n] }
    }
}

/// The transform of one size, with its twiddle factors.
#[derive(Debug, Clone)]
pub(super) struct Fourier {
    n: usize,
    /// exp(2 pi i p / n) for p < n/2.
    twiddles: Vec<(f32, f32)>,
}

impl Fourier {
    /// For maps of `n` x `n`; `n` is a power of two.
    pub(super) fn new(n: usize) -> Self {
        let twiddles = (0..n / 2)
            .map(|p| {
                let (sin, cos) = libm::sincos(core::f64::consts::TAU * p as f64 / n as f64);
                (cos as f32, sin as f32)
            })
            .collect();
        Self { n, twiddles }
    }

    /// Transforms `map` in place, from index [i][j] to index [y][x]. `other` is working memory.
    pub(super) fn inverse(&self, simd: Simd, map: &mut Map, other: &mut Map) {
        columns(simd, self.n, &self.twiddles, map, other);
        transpose(simd, self.n, &map.re, &mut other.re);
        transpose(simd, self.n, &map.im, &mut other.im);
        core::mem::swap(map, other);
        columns(simd, self.n, &self.twiddles, map, other);
    }
}

multiversion! { simd;
    /// Transforms every column in place.
    fn columns(simd: Simd, n: usize, twiddles: &[(f32, f32)], map: &mut Map, other: &mut Map) {
        let mut stride = 1;
        let mut length = n;
        while length > 1 {
            let half = length / 2;
            for p in 0..half {
                let (wr, wi) = twiddles[p * stride];
                // The rows of q = 0..stride lie next to each other: one long run.
                let run = stride * n;
                let (a, b) = (stride * p * n, stride * (p + half) * n);
                let (c, d) = (stride * 2 * p * n, stride * (2 * p + 1) * n);
                let (ar, ai) = (&map.re[a..a + run], &map.im[a..a + run]);
                let (br, bi) = (&map.re[b..b + run], &map.im[b..b + run]);
                let (cr, dr) = other.re[c..d + run].split_at_mut(run);
                let (ci, di) = other.im[c..d + run].split_at_mut(run);
                for q in 0..run {
                    let (re, im) = (ar[q] - br[q], ai[q] - bi[q]);
                    cr[q] = ar[q] + br[q];
                    ci[q] = ai[q] + bi[q];
                    dr[q] = re * wr - im * wi;
                    di[q] = re * wi + im * wr;
                }
            }
            core::mem::swap(&mut map.re, &mut other.re);
            core::mem::swap(&mut map.im, &mut other.im);
            stride *= 2;
            length = half;
        }
    }
}

multiversion! { simd;
    fn transpose(simd: Simd, n: usize, from: &[f32], to: &mut [f32]) {
        const BLOCK: usize = 16;
        for top in (0..n).step_by(BLOCK) {
            for left in (0..n).step_by(BLOCK) {
                for row in top..top + BLOCK {
                    for column in left..left + BLOCK {
                        to[column * n + row] = from[row * n + column];
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_sum_that_defines_it() {
        let n = 16;
        let mut map = Map::zeros(n);
        let modes =
            [((1, 0), (0.5, 0.25)), ((3, 14), (-1.0, 0.5)), ((0, 0), (0.1, 0.0)), ((15, 8), (0.3, 0.7))];
        for ((i, j), (re, im)) in modes {
            map.re[i * n + j] = re;
            map.im[i * n + j] = im;
        }
        Fourier::new(n).inverse(Simd::widest(), &mut map, &mut Map::zeros(n));
        for y in 0..n {
            for x in 0..n {
                let (mut re, mut im) = (0.0, 0.0);
                for ((i, j), (a, b)) in modes {
                    let turn = core::f64::consts::TAU * ((i * x + j * y) as f64) / n as f64;
                    let (sin, cos) = libm::sincos(turn);
                    re += f64::from(a) * cos - f64::from(b) * sin;
                    im += f64::from(a) * sin + f64::from(b) * cos;
                }
                assert!((f64::from(map.re[y * n + x]) - re).abs() < 1e-5);
                assert!((f64::from(map.im[y * n + x]) - im).abs() < 1e-5);
            }
        }
    }
}
