//! Tiles of values for bilinear look-up at several scales.
//!
//! A *texel* holds 16 bits: two signed bytes, or one signed number. A *quad* packs a texel with its
//! neighbours to the right, below, and both into one `u64`, so that a bilinear look-up is one load. *Level* l
//! averages 2^l x 2^l texels of level 0. The quads of the level with `n` texels along its side lie at
//! `n*n .. 2*n*n`.

use barrelman_simd::{Simd, multiversion};

use super::texture::ROUNDING;

/// Quads of a map of any size: enough for 256 x 256 with all levels. The size is fixed so that a masked index
/// needs no bounds check.
pub(super) const QUADS: usize = 1 << 17;

/// A tile at all its scales.
#[derive(Debug, Clone)]
pub(super) struct QuadMap {
    pub(super) quads: Box<[u64; QUADS]>,
    texels: Vec<u16>,
    n: usize,
}

/// Meaning of a texel's 16 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Texel {
    /// Two signed bytes, the first map in the lower one, in steps of this.
    Pair(f32),
    /// One signed number, of the first map only, in steps of this.
    Single(f32),
}

impl QuadMap {
    /// An empty map for tiles of `n` x `n` texels; `n` is a power of two, at most 256.
    pub(super) fn new(n: usize) -> Self {
        let zeros = vec![0_u64; QUADS].into_boxed_slice();
        let quads = zeros.try_into().unwrap_or_else(|_| Box::new([0; QUADS]));
        Self { quads, texels: vec![0; (n + 1) * n], n }
    }

    /// Fills all levels from two maps of `n` x `n`, which are overwritten.
    pub(super) fn fill(&mut self, simd: Simd, first: &mut [f32], second: &mut [f32], texel: Texel) {
        let mut n = self.n;
        loop {
            quantise(simd, n, first, second, texel, &mut self.texels);
            pack(simd, n, &self.texels, &mut self.quads[n * n..2 * n * n]);
            if n == 1 {
                break;
            }
            n /= 2;
            halve(simd, n, first);
            halve(simd, n, second);
        }
    }
}

multiversion! { simd;
    /// Quantises to rows of `n + 1` texels; the last column repeats the first.
    fn quantise(simd: Simd, n: usize, first: &[f32], second: &[f32], texel: Texel, texels: &mut [u16]) {
        for row in 0..n {
            let a = &first[row * n..][..n];
            let b = &second[row * n..][..n];
            let out = &mut texels[row * (n + 1)..][..n + 1];
            match texel {
                Texel::Pair(step) => {
                    let scale = 1.0 / step;
                    for i in 0..n {
                        let x = (a[i] * scale).max(-127.0).min(127.0) + ROUNDING;
                        let y = (b[i] * scale).max(-127.0).min(127.0) + ROUNDING;
                        out[i] = (x.to_bits() & 0xFF | (y.to_bits() & 0xFF) << 8) as u16;
                    }
                }
                Texel::Single(step) => {
                    let scale = 1.0 / step;
                    for i in 0..n {
                        let x = (a[i] * scale).max(-32_767.0).min(32_767.0) + ROUNDING;
                        out[i] = x.to_bits() as u16;
                    }
                }
            }
            out[n] = out[0];
        }
    }
}

multiversion! { simd;
    fn pack(simd: Simd, n: usize, texels: &[u16], quads: &mut [u64]) {
        for row in 0..n {
            let upper = &texels[row * (n + 1)..][..n + 1];
            let lower = &texels[((row + 1) % n) * (n + 1)..][..n + 1];
            let out = &mut quads[row * n..][..n];
            for i in 0..n {
                out[i] = u64::from(upper[i])
                    | u64::from(upper[i + 1]) << 16
                    | u64::from(lower[i]) << 32
                    | u64::from(lower[i + 1]) << 48;
            }
        }
    }
}

multiversion! { simd;
    /// Averages 2 x 2 values to a map of `n` x `n` at the start of the same memory.
    fn halve(simd: Simd, n: usize, map: &mut [f32]) {
        for row in 0..n {
            for column in 0..n {
                let at = 4 * row * n + 2 * column;
                map[row * n + column] =
                    0.25 * ((map[at] + map[at + 1]) + (map[at + 2 * n] + map[at + 2 * n + 1]));
            }
        }
    }
}
