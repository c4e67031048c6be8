//! Where rays meet the waves, and the slopes there: from three tiles, each at the level that fits the pixel's
//! footprint. Slopes that a level has averaged away are kept as variance, which later widens reflections and
//! glitter. Distant water therefore neither aliases nor turns into a mirror (`bruneton2010`).
//!
//! *Relief*: the ray is followed twice to the elevation found where it meets the plane, so that crests stand
//! in front of troughs. A crest that hides what lies behind it is not handled.

use barrelman_simd::{Simd, multiversion};

use super::chunk::{CHUNK, Chunk, Lane};
use super::nodes::{GROUP, Nodes};
use super::quad_map::{QUADS, QuadMap};
use super::rays::HORIZON;
use super::texture::{ROUNDING, Texture};
use super::waves::{LEVELS, WaveTile};

/// The data that the surface is looked up in.
#[derive(Clone, Copy)]
pub(super) struct WaterSurface<'a> {
    pub(super) tiles: [TileLookup<'a>; 3],
    /// Elevation of the swell on tile 0's grid; `None` where the sea is too flat for relief.
    pub(super) elevation: Option<ElevationMap<'a>>,
    /// Foam of breaking crests on tile 0's grid.
    pub(super) foam: Option<&'a QuadMap>,
    /// Pattern of gusts.
    pub(super) gusts: &'a Texture,
    /// Position below the camera, texels of `gusts`.
    pub(super) gust_origin: (f32, f32),
    /// Variance of slope that no tile carries.
    pub(super) unresolved_variance: f32,
}

/// One tile, looked up relative to a camera.
#[derive(Clone, Copy)]
pub(super) struct TileLookup<'a> {
    quads: &'a [u64; QUADS],
    n: f32,
    /// Cosine and sine of the tile's rotation over its side, 1/m.
    along: (f32, f32),
    /// Position below the camera, tile sides.
    origin: (f32, f32),
    slope_step: f32,
    texels_per_metre: f32,
    /// From this footprint on, a pixel sees nothing of the tile's slopes, metres.
    flat_from_m: f32,
    lost: &'a [f32; LEVELS],
}

/// A tile of single numbers.
#[derive(Clone, Copy)]
pub(super) struct ElevationMap<'a> {
    pub(super) quads: &'a [u64; QUADS],
    pub(super) step: f32,
}

impl WaterSurface<'_> {
    /// Upper bound of the shift of a point by relief, metres.
    pub(super) fn max_relief_m(&self) -> f32 {
        // The largest elevation over the limit of the sink.
        self.elevation.map_or(0.0, |values| 32_767.0 * values.step / 0.10 * 1.5)
    }
}

impl<'a> TileLookup<'a> {
    /// For a camera above this point of the world.
    pub(super) fn new(tile: &'a WaveTile, x: f64, y: f64) -> Self {
        let (cos, sin) = tile.turn;
        let (u, v) = ((x * cos + y * sin) / tile.side_m, (y * cos - x * sin) / tile.side_m);
        let texels_per_metre = (tile.n as f64 / tile.side_m) as f32;
        Self {
            quads: &tile.slopes.quads,
            n: tile.n as f32,
            texels_per_metre,
            flat_from_m: (1_u32 << tile.flat_level) as f32 / texels_per_metre,
            along: ((cos / tile.side_m) as f32, (sin / tile.side_m) as f32),
            origin: ((u - libm::floor(u)) as f32, (v - libm::floor(v)) as f32),
            slope_step: tile.slope_step,
            lost: &tile.lost,
        }
    }

    /// Computes levels, indices of quads and positions within them for all pixels. The quads are loaded in a
    /// loop of their own, so that all but the loads is vectorised.
    #[inline(always)]
    fn find(&self, chunk: &Chunk, footprint: &Lane, found: &mut QuadLookup) {
        let coarsest = self.coarsest();
        for i in 0..CHUNK {
            let texels = footprint[i] * self.texels_per_metre;
            let level = ((texels.to_bits() >> 23) as i32 - 127).max(0).min(coarsest);
            let shrink = f32::from_bits(((127 - level) << 23) as u32);
            let (px, py) = (chunk.px[i], chunk.py[i]);
            let u = self.origin.0 + px * self.along.0 + py * self.along.1;
            let v = self.origin.1 + py * self.along.0 - px * self.along.1;
            let n = self.n * shrink;
            // Level l averages texels: its first one stands (1 - 2^-l) / 2 of its own width to the right.
            let shift = 1.0 - 0.5 * shrink;
            let (u, v) = (u * n - shift, v * n - shift);
            let (mu, mv) = (u + ROUNDING, v + ROUNDING);
            let mask = ((n + ROUNDING).to_bits() as i32 & 0xFFFF) - 1;
            let (iu, iv) = (mu.to_bits() as i32 & mask, mv.to_bits() as i32 & mask);
            found.index[i] = ((mask + 1) * (mask + 1 + iv) + iu) as u32;
            found.fu[i] = u - (mu - ROUNDING) + 0.5;
            found.fv[i] = v - (mv - ROUNDING) + 0.5;
        }
    }

    #[inline(always)]
    fn coarsest(&self) -> i32 {
        (self.n.to_bits() >> 23) as i32 - 127
    }

    /// The variance lost at a footprint, interpolated between levels.
    #[inline(always)]
    fn lost_variance(&self, footprint: f32) -> f32 {
        let texels = (footprint * self.texels_per_metre).max(1.0).min(self.n);
        let level = (texels.to_bits() >> 23) as usize - 127;
        let part = f32::from_bits(texels.to_bits() & 0x7F_FFFF | 0x3F80_0000) - 1.0;
        let (here, next) = (self.lost[level & (LEVELS - 1)], self.lost[(level + 1) & (LEVELS - 1)]);
        here + part * (next - here)
    }
}

/// Quads of all pixels, and each pixel's position in its quad.
struct QuadLookup {
    index: [u32; CHUNK],
    fu: Lane,
    fv: Lane,
    upper: [u32; CHUNK],
    lower: [u32; CHUNK],
}

impl QuadLookup {
    #[inline(always)]
    fn empty() -> Self {
        Self { index: [0; CHUNK], fu: [0.0; CHUNK], fv: [0.0; CHUNK], upper: [0; CHUNK], lower: [0; CHUNK] }
    }

    #[inline(always)]
    fn load(&mut self, quads: &[u64; QUADS]) {
        for i in 0..CHUNK {
            let quad = quads[self.index[i] as usize & (QUADS - 1)];
            self.upper[i] = quad as u32;
            self.lower[i] = (quad >> 32) as u32;
        }
    }

    /// Both bytes, interpolated.
    #[inline(always)]
    fn pair(&self, i: usize) -> (f32, f32) {
        let (upper, lower, fu, fv) = (self.upper[i], self.lower[i], self.fu[i], self.fv[i]);
        let value = |first: u32, second: u32| {
            bilinear(
                signed_byte(upper, first),
                signed_byte(upper, second),
                signed_byte(lower, first),
                signed_byte(lower, second),
                fu,
                fv,
            )
        };
        (value(0, 16), value(8, 24))
    }

    /// The number, interpolated.
    #[inline(always)]
    fn single(&self, i: usize) -> f32 {
        let low = |bits: u32| ((bits << 16) as i32 >> 16) as f32;
        let high = |bits: u32| (bits as i32 >> 16) as f32;
        let (upper, lower) = (self.upper[i], self.lower[i]);
        bilinear(low(upper), high(upper), low(lower), high(lower), self.fu[i], self.fv[i])
    }
}

#[inline(always)]
fn signed_byte(bits: u32, shift: u32) -> f32 {
    ((bits << (24 - shift)) as i32 >> 24) as f32
}

#[inline(always)]
fn bilinear(a: f32, b: f32, c: f32, d: f32, fu: f32, fv: f32) -> f32 {
    let (upper, lower) = (a + fu * (b - a), c + fu * (d - c));
    upper + fv * (lower - upper)
}

/// Factors from 1 to 2 that spread the change of level over neighbouring pixels without a visible pattern.
/// Rows use the same order with different starts; the order is stored twice so that it can start anywhere.
const DITHER: [f32; 2 * CHUNK] = {
    let mut factors = [0.0; 2 * CHUNK];
    let mut i = 0;
    while i < 2 * CHUNK {
        // 2^x on 0..1 by a parabola through both ends; the numbers i * 37 + ... mod 64 come in no visible
        // order.
        let j = i % CHUNK;
        let k = (j * j * 11 + j * 37 + (j >> 2) * 29) % CHUNK;
        let x = (k as f32 + 0.5) / CHUNK as f32;
        factors[i] = 1.0 + x * (0.656 + 0.344 * x);
        i += 1;
    }
    factors
};

multiversion! { simd;
    /// Computes gusts and the variance below the pixels' resolution at the nodes of a row.
    pub(super) fn fill_node_variance(simd: Simd, water: &WaterSurface<'_>, nodes: &mut Nodes) {
        let [swell, longer, shorter] = &water.tiles;
        for first in (0..nodes.count()).step_by(GROUP) {
            let group = first..first + GROUP;
            let (px, py) = (&nodes.px.0[group.clone()], &nodes.py.0[group.clone()]);
            let footprint = &nodes.footprint.0[group.clone()];
            // Separate memory for the results, so that the compiler need not assume aliasing.
            let mut gust = [0.0_f32; GROUP];
            for i in 0..GROUP {
                let (u, v) =
                    (water.gust_origin.0 + 2.1 * px[i], water.gust_origin.1 + 2.1 * py[i]);
                gust[i] = 0.45 + (1.1 / 255.0) * water.gusts.sample(u, v);
            }
            let mut variance = [0.0_f32; GROUP];
            for i in 0..GROUP {
                let short = water.unresolved_variance + longer.lost_variance(footprint[i]) + shorter.lost_variance(footprint[i]);
                variance[i] = swell.lost_variance(footprint[i]) + gust[i] * gust[i] * short;
            }
            nodes.gust.0[group.clone()].copy_from_slice(&gust);
            nodes.variance.0[group].copy_from_slice(&variance);
        }
    }
}

/// Moves the points where rays meet level water to where they meet the swell, in two steps.
#[inline(always)]
fn raise(water: &WaterSurface<'_>, chunk: &mut Chunk, found: &mut QuadLookup) {
    let Some(elevation) = water.elevation else { return };
    // No dither here: an elevation that jumps from pixel to pixel would tear the picture.
    let footprint = chunk.footprint;
    for _ in 0..2 {
        water.tiles[0].find(chunk, &footprint, found);
        found.load(elevation.quads);
        for i in 0..CHUNK {
            let eta = found.single(i) * elevation.step;
            let sink = if -chunk.dz[i] > HORIZON { -chunk.dz[i] } else { HORIZON };
            // At grazing angles the full shift would fold the picture; it is limited to what a crest hides.
            let length = chunk.t[i] - eta / (sink + 0.10);
            chunk.elevation[i] = eta;
            chunk.px[i] = length * chunk.dx[i];
            chunk.py[i] = length * chunk.dy[i];
        }
    }
}

multiversion! { simd;
    /// Computes slopes, elevation and whitecaps of a chunk whose rays are cast. `start` is its row and first
    /// column.
    pub(super) fn sample_surface(
        simd: Simd,
        water: &WaterSurface<'_>,
        nodes: &Nodes,
        start: (usize, usize),
        chunk: &mut Chunk,
    ) {
        let (row, column) = start;
        let mut sized = [0.0_f32; CHUNK];
        let dither = &DITHER[(23 * row) % CHUNK..][..CHUNK];
        for i in 0..CHUNK {
            sized[i] = chunk.footprint[i] * dither[i];
        }
        let (min_footprint, _) = nodes.footprint.range(column);
        let swell = &water.tiles[0];
        let mut found = QuadLookup::empty();
        raise(water, chunk, &mut found);
        chunk.foam = [0.0; CHUNK];
        if min_footprint < swell.flat_from_m || water.foam.is_some() {
            swell.find(chunk, &sized, &mut found);
            found.load(swell.quads);
            for i in 0..CHUNK {
                let (sx, sy) = found.pair(i);
                chunk.sx[i] = sx * swell.slope_step;
                chunk.sy[i] = sy * swell.slope_step;
            }
            if let Some(foam) = water.foam {
                found.load(&foam.quads);
                for i in 0..CHUNK {
                    chunk.foam[i] = found.pair(i).0 * (0.62 / 127.0);
                }
            }
        } else {
            chunk.sx = [0.0; CHUNK];
            chunk.sy = [0.0; CHUNK];
        }
        let gust = nodes.gust.lane(column);
        for lookup in &water.tiles[1..] {
            if min_footprint < lookup.flat_from_m {
                lookup.find(chunk, &sized, &mut found);
                found.load(lookup.quads);
                for i in 0..CHUNK {
                    let (sx, sy) = found.pair(i);
                    let step = gust[i] * lookup.slope_step;
                    chunk.sx[i] += step * sx;
                    chunk.sy[i] += step * sy;
                }
            }
        }
        chunk.air = [0.0; CHUNK];
        chunk.lit = [1.0; CHUNK];
        chunk.sky_left = [1.0; CHUNK];
        chunk.reflection = [[0.0; CHUNK]; 3];
    }
}
