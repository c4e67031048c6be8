//! Textures made from noise: clouds, gusts, grain, and the lace of foam. All are square and periodic, and a
//! bilinear look-up is one load.

use crate::noise;

/// Texels along the side of every texture.
pub(super) const SIDE: usize = 256;
const MASK: u32 = SIDE as u32 - 1;
const TEXELS: usize = SIDE * SIDE;

/// A texture: each texel packed with its neighbours to the right, below, and both, a byte each.
#[derive(Debug, Clone)]
pub(super) struct Texture {
    quads: Box<[u32; TEXELS]>,
}

/// The textures of a renderer.
#[derive(Debug)]
pub(super) struct Textures {
    pub(super) clouds: Texture,
    pub(super) gusts: Texture,
    pub(super) grain: Texture,
    pub(super) lace: Texture,
}

impl Textures {
    /// All textures, from the renderer's seed.
    pub(super) fn new(seed: u64) -> Self {
        Self {
            clouds: Texture::fractal(seed ^ 0xC1, 64, 1, 0.52),
            gusts: Texture::fractal(seed ^ 0x65, 64, 4, 0.55),
            grain: Texture::fractal(seed ^ 0x62, 16, 1, 0.75),
            lace: Texture::lace(seed ^ 0x1A, 16),
        }
    }
}

/// The nearest whole number of a float of less than 2^22 in size.
pub(super) fn round_to_i32(v: f32) -> i32 {
    ((v + ROUNDING) - ROUNDING) as i32
}

/// Added to a float of less than 2^22 in size, this leaves the nearest whole number in the lowest bits.
pub(super) const ROUNDING: f32 = 12_582_912.0;

impl Texture {
    fn from_values(value: impl Fn(usize, usize) -> f64) -> Self {
        let bytes: Vec<u32> = (0..TEXELS)
            .map(|at| libm::rint(255.0 * value(at % SIDE, at / SIDE).clamp(0.0, 1.0)) as u32)
            .collect();
        let at = |x: usize, y: usize| bytes[(y % SIDE) * SIDE + x % SIDE];
        let quads: Vec<u32> = (0..TEXELS)
            .map(|i| {
                let (x, y) = (i % SIDE, i / SIDE);
                at(x, y) | at(x + 1, y) << 8 | at(x, y + 1) << 16 | at(x + 1, y + 1) << 24
            })
            .collect();
        let quads = quads.into_boxed_slice().try_into().unwrap_or_else(|_| Box::new([0; TEXELS]));
        Self { quads }
    }

    /// Fractal noise: octaves from cells of `coarsest` down to `finest` texels, each `fall` times the one
    /// before, scaled to fill 0..1.
    pub(super) fn fractal(seed: u64, coarsest: usize, finest: usize, fall: f64) -> Self {
        let mut sums = vec![0.0; TEXELS];
        let (mut cell, mut weight, mut stream) = (coarsest, 1.0, 0);
        while cell >= finest.max(1) {
            let cells = SIDE / cell;
            let corner =
                |x: usize, y: usize| noise::unit(seed, stream, ((y % cells) * cells + x % cells) as u64);
            for (at, sum) in sums.iter_mut().enumerate() {
                let (x, y) = (at % SIDE, at / SIDE);
                let ease = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
                let (fx, fy) = (ease((x % cell) as f64 / cell as f64), ease((y % cell) as f64 / cell as f64));
                let (cx, cy) = (x / cell, y / cell);
                let upper = corner(cx, cy) * (1.0 - fx) + corner(cx + 1, cy) * fx;
                let lower = corner(cx, cy + 1) * (1.0 - fx) + corner(cx + 1, cy + 1) * fx;
                *sum += weight * (upper * (1.0 - fy) + lower * fy - 0.5);
            }
            cell /= 2;
            weight *= fall;
            stream += 1;
        }
        let largest = sums.iter().fold(1e-9_f64, |largest, sum| largest.max(sum.abs()));
        Self::from_values(|x, y| 0.5 + 0.5 * sums[y * SIDE + x] / largest)
    }

    /// The lace of foam: high along the borders between cells of about `cell` texels, finer within.
    pub(super) fn lace(seed: u64, cell: usize) -> Self {
        let coarse = Cells { seed, cell };
        let fine = Cells { seed: seed ^ 0xF1, cell: cell / 2 };
        let warp = Self::fractal(seed ^ 0x3A, 32, 4, 0.6);
        Self::from_values(|x, y| {
            let bend = |x: usize, y: usize| {
                (f64::from((warp.quads[(y % SIDE) * SIDE + x % SIDE] & 0xFF) as u8) / 255.0 - 0.5)
                    * cell as f64
            };
            let (u, v) = (x as f64 + bend(x, y), y as f64 + bend(x + 97, y + 31));
            let border = |cells: &Cells| {
                let (first, second) = cells.nearest(u, v);
                1.0 - ((second - first) / (0.75 * cells.cell as f64)).min(1.0)
            };
            0.62 * border(&coarse) + 0.38 * border(&fine)
        })
    }

    /// The value at a position in texels, 0 to 255.
    #[inline(always)]
    pub(super) fn sample(&self, u: f32, v: f32) -> f32 {
        let (mu, mv) = ((u - 0.5) + ROUNDING, (v - 0.5) + ROUNDING);
        let (fu, fv) = (u - (mu - ROUNDING), v - (mv - ROUNDING));
        let index = (mv.to_bits() & MASK) * SIDE as u32 + (mu.to_bits() & MASK);
        let quad = self.quads[index as usize];
        let (a, b) = ((quad & 0xFF) as i32 as f32, (quad >> 8 & 0xFF) as i32 as f32);
        let (c, d) = ((quad >> 16 & 0xFF) as i32 as f32, (quad >> 24) as i32 as f32);
        let (upper, lower) = (a + fu * (b - a), c + fu * (d - c));
        upper + fv * (lower - upper)
    }
}

/// A random point in each square cell.
struct Cells {
    seed: u64,
    cell: usize,
}

impl Cells {
    /// Distances to the nearest and the second nearest point, texels.
    fn nearest(&self, u: f64, v: f64) -> (f64, f64) {
        let cells = (SIDE / self.cell) as i64;
        let size = self.cell as f64;
        let (cx, cy) = (libm::floor(u / size) as i64, libm::floor(v / size) as i64);
        let (mut first, mut second) = (f64::MAX, f64::MAX);
        for y in cy - 1..=cy + 1 {
            for x in cx - 1..=cx + 1 {
                let index = (y.rem_euclid(cells) * cells + x.rem_euclid(cells)) as u64;
                let (dx, dy) = (
                    (x as f64 + noise::unit(self.seed, 1, index)) * size - u,
                    (y as f64 + noise::unit(self.seed, 2, index)) * size - v,
                );
                let distance = libm::sqrt(dx * dx + dy * dy);
                if distance < first {
                    (first, second) = (distance, first);
                } else if distance < second {
                    second = distance;
                }
            }
        }
        (first, second)
    }
}
