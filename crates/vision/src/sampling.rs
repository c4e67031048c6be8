//! Bilinear sampling of a map on a rotated and scaled grid.

use crate::simd::simd_kernel;

/// A greyscale map, rows tightly packed.
#[derive(Debug, Clone, Default)]
pub(crate) struct SampleMap {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<u8>,
    /// Each sample with its right, lower and lower right neighbours, one byte each: one load per bilinear
    /// sample.
    quads: Vec<u32>,
}

impl SampleMap {
    /// Becomes a copy of another map, in the buffers that are there. They get the other map's capacity, so
    /// that a copy of the largest map that it held so far allocates nothing.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        (self.width, self.height) = (other.width, other.height);
        copy_with_capacity(&mut self.values, &other.values);
        copy_with_capacity(&mut self.quads, &other.quads);
    }

    /// Prepares the map for [`sample_bilinear`]; to be called after `values` changed. The map must not be
    /// empty.
    pub(crate) fn pack(&mut self) {
        self.quads.clear();
        // Room for as many as there is for values, so that a map whose values need no memory needs none here.
        self.quads.reserve(self.values.capacity());
        pack_quads(self);
    }
}

fn copy_with_capacity<T: Copy>(to: &mut Vec<T>, from: &Vec<T>) {
    to.clear();
    to.reserve_exact(from.capacity());
    to.extend_from_slice(from);
}

simd_kernel! {
fn pack_quads(map: &mut SampleMap) {
    for row in 0..map.height {
        let here = &map.values[row * map.width..][..map.width];
        let below = &map.values[(row + 1).min(map.height - 1) * map.width..][..map.width];
        let quad = |a: u8, b: u8, c: u8, d: u8| u32::from_le_bytes([a, b, c, d]);
        let pairs = here.windows(2).zip(below.windows(2));
        map.quads.extend(pairs.map(|(h, b)| quad(h[0], h[1], b[0], b[1])));
        let (h, b) = (here[map.width - 1], below[map.width - 1]);
        map.quads.push(quad(h, h, b, b));
    }
}
}

/// A rectangular grid of samples, rotated and scaled, placed on a picture or a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SamplingGrid {
    /// Centre of the grid, pixels.
    pub(crate) centre: (f32, f32),
    /// Distance of neighbouring samples in a row, pixels.
    pub(crate) step: f32,
    /// Distance of rows over that of samples in a row.
    pub(crate) stretch: f32,
    /// Cosine and sine of the rotation, clockwise as seen.
    pub(crate) turn: (f32, f32),
    /// Samples per row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
}

impl SamplingGrid {
    /// A grid placed on the picture, in samples of a map whose left upper corner is at `origin` (pixels) and
    /// which has `scale` samples per pixel.
    pub(crate) fn on_map(&self, origin: (f32, f32), scale: f32) -> Self {
        let centre = ((self.centre.0 - origin.0) * scale, (self.centre.1 - origin.1) * scale);
        Self { centre, step: self.step * scale, ..*self }
    }

    /// Centre of a sample of a grid that is not rotated.
    pub(crate) fn sample_centre(&self, column: usize, row: usize) -> (f32, f32) {
        let from_middle = |index: usize, count: usize| index as f32 + 0.5 - 0.5 * count as f32;
        (
            self.centre.0 + from_middle(column, self.width) * self.step,
            self.centre.1 + from_middle(row, self.height) * self.step * self.stretch,
        )
    }

    /// Centre of a block of 2 x 2 samples of a grid that is not rotated.
    pub(crate) fn block_centre(&self, column: usize, row: usize) -> (f32, f32) {
        let (u, v) = self.sample_centre(2 * column, 2 * row);
        (u + 0.5 * self.step, v + 0.5 * self.step * self.stretch)
    }
}

/// Scratch space for one row of samples: the four neighbours of each, and the position between them.
#[derive(Debug, Clone, Default)]
pub(crate) struct SampleRow {
    quads: Vec<u32>,
    /// Fractions to the right (low half) and downwards (high half), 0 to 255 each.
    fraction: Vec<u32>,
}

simd_kernel! {
/// Samples `map` at the points of `grid` (in samples of the map) by bilinear interpolation, with positions
/// rounded to 1/256 sample. Outside the map the border samples are replicated.
pub(crate) fn sample_bilinear(map: &SampleMap, grid: SamplingGrid, line: &mut SampleRow, out: &mut Vec<f32>) {
    const ONE: f32 = 65_536.0;
    out.resize(grid.width * grid.height, 0.0);
    line.quads.resize(grid.width, 0);
    line.fraction.resize(grid.width, 0);
    let right = (grid.turn.0 * grid.step, grid.turn.1 * grid.step);
    let down = (-right.1 * grid.stretch, right.0 * grid.stretch);
    let (half_w, half_h) = (0.5 * (grid.width as f32 - 1.0), 0.5 * (grid.height as f32 - 1.0));
    let step = ((right.0 * ONE) as i32, (right.1 * ONE) as i32);
    let limit = (((map.width as i32 - 1) << 16) | 0xff00, ((map.height as i32 - 1) << 16) | 0xff00);
    let last = grid.width as i32 - 1;
    for (row, out) in out.chunks_exact_mut(grid.width).enumerate() {
        let off = row as f32 - half_h;
        // The centre of sample (0, 0) is at (0.5, 0.5).
        let x = ((grid.centre.0 - 0.5 + off * down.0 - half_w * right.0) * ONE) as i32;
        let y = ((grid.centre.1 - 0.5 + off * down.1 - half_w * right.1) * ONE) as i32;
        let end = (x.saturating_add(step.0.saturating_mul(last)), y.saturating_add(step.1.saturating_mul(last)));
        let inside = |from: i32, to: i32, limit: i32| from.min(to) >= 0 && from.max(to) <= limit;
        let SampleRow { quads, fraction } = line;
        let width = map.width as u32;
        if inside(x, end.0, limit.0) && inside(y, end.1, limit.1) {
            let (from, step) = ((x as u32, y as u32), (step.0 as u32, step.1 as u32));
            for ((quad, fraction), k) in quads.iter_mut().zip(fraction.iter_mut()).zip(0_u32..) {
                let (x, y) = (from.0.wrapping_add(k.wrapping_mul(step.0)), from.1.wrapping_add(k.wrapping_mul(step.1)));
                *quad = (y >> 16) * width + (x >> 16);
                *fraction = ((x >> 8) & 0xff) | ((y & 0xff00) << 8);
            }
        } else {
            let (mut x, mut y) = (x, y);
            for (quad, fraction) in quads.iter_mut().zip(fraction.iter_mut()) {
                let (cx, cy) = (x.clamp(0, limit.0) as u32, y.clamp(0, limit.1) as u32);
                *quad = (cy >> 16) * width + (cx >> 16);
                *fraction = ((cx >> 8) & 0xff) | ((cy & 0xff00) << 8);
                x = x.saturating_add(step.0);
                y = y.saturating_add(step.1);
            }
        }
        // From each sample's index to its neighbours: the loops before and after this one have no such
        // lookup, so that they can be vectorised.
        for quad in quads.iter_mut() {
            *quad = map.quads[*quad as usize];
        }
        for ((out, &quad), &fraction) in out.iter_mut().zip(quads.iter()).zip(fraction.iter()) {
            // Bytes and half words: the casts are lossless. Signed conversions are the fast ones.
            let byte = |shift: u32| ((quad >> shift) & 0xff) as i32 as f32;
            let (fx, fy) = ((fraction & 0xffff) as i32 as f32 * (1.0 / 256.0), (fraction >> 16) as i32 as f32 * (1.0 / 256.0));
            let (a, b, c, d) = (byte(0), byte(8), byte(16), byte(24));
            let upper = a + (b - a) * fx;
            let lower = c + (d - c) * fx;
            *out = upper + (lower - upper) * fy;
        }
    }
}
}
