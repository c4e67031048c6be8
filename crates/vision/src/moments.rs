//! Image moments of a map of weights over a window, up to the second order.
//!
//! With p(x, y) the weight (0 to 255) of the pixel in column x and row y, the moment of order (i, j) over a
//! window is m_ij = sum of p(x, y) x^i y^j. All sums are integers and exact; 64 bits suffice for pictures of
//! up to 16384 x 16384 pixels.

use core::ops::{AddAssign, SubAssign};

use crate::window::Window;

/// Moments over a window; x and y are counted in whole pixels from the map's top left pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Moments {
    /// Sum of the weights.
    pub m00: u64,
    /// Sum of weight times x.
    pub m10: u64,
    /// Sum of weight times y.
    pub m01: u64,
    /// Sum of weight times x squared.
    pub m20: u64,
    /// Sum of weight times x times y.
    pub m11: u64,
    /// Sum of weight times y squared.
    pub m02: u64,
}

impl AddAssign for Moments {
    fn add_assign(&mut self, other: Self) {
        self.m00 += other.m00;
        self.m10 += other.m10;
        self.m01 += other.m01;
        self.m20 += other.m20;
        self.m11 += other.m11;
        self.m02 += other.m02;
    }
}

impl SubAssign for Moments {
    /// Subtracts a part of what was summed.
    fn sub_assign(&mut self, part: Self) {
        self.m00 -= part.m00;
        self.m10 -= part.m10;
        self.m01 -= part.m01;
        self.m20 -= part.m20;
        self.m11 -= part.m11;
        self.m02 -= part.m02;
    }
}

/// Moments over a moving window: only the pixels that enter and leave are summed. The sums are integers, so
/// the result equals that of a full sum.
pub(crate) struct RunningMoments<'a, M> {
    map: &'a mut M,
    window: Window,
    sums: Moments,
}

impl<'a, M: MomentSource> RunningMoments<'a, M> {
    pub(crate) fn new(map: &'a mut M) -> Self {
        Self { map, window: Window::default(), sums: Moments::default() }
    }

    /// The moments over the part of `window` in the map.
    pub(crate) fn moments_over(&mut self, window: Window) -> Moments {
        let window = window.clipped(self.map.width(), self.map.height());
        let (entering, leaving) = (window.difference(self.window), self.window.difference(window));
        let area = |pieces: [Window; 4]| pieces.into_iter().map(Window::area).sum::<usize>();
        if area(entering) + area(leaving) < window.area() {
            for piece in entering.into_iter().filter(|piece| !piece.is_empty()) {
                self.sums += self.map.moments(piece);
            }
            for piece in leaving.into_iter().filter(|piece| !piece.is_empty()) {
                self.sums -= self.map.moments(piece);
            }
        } else {
            self.sums = self.map.moments(window);
        }
        self.window = window;
        self.sums
    }
}

/// A map of weights whose moments over a window can be computed.
pub trait MomentSource {
    /// Columns of the map.
    fn width(&self) -> usize;
    /// Rows of the map.
    fn height(&self) -> usize;
    /// The moments over the part of `window` in the map.
    fn moments(&mut self, window: Window) -> Moments;
}

/// A borrowed map of weights, one byte per pixel, rows tightly packed.
#[derive(Debug, Clone, Copy)]
pub struct WeightMap<'a> {
    weights: &'a [u8],
    width: usize,
    height: usize,
}

impl<'a> WeightMap<'a> {
    /// A map of `width` columns and as many whole rows as `weights` contains, at most `height`.
    pub fn new(weights: &'a [u8], width: usize, height: usize) -> Self {
        let rows = weights.len().checked_div(width).unwrap_or(0);
        Self { weights, width, height: height.min(rows) }
    }
}

impl MomentSource for WeightMap<'_> {
    fn width(&self) -> usize {
        self.width
    }

    fn height(&self) -> usize {
        self.height
    }

    fn moments(&mut self, window: Window) -> Moments {
        let window = window.clipped(self.width, self.height);
        let mut sums = Moments::default();
        if window.is_empty() {
            return sums;
        }
        let rows = self.weights.chunks_exact(self.width).enumerate().skip(window.y).take(window.h);
        for (y, row) in rows {
            let row_sums = RowSums::new(&row[window.x..][..window.w]);
            let (x, y) = (window.x as u64, y as u64);
            let along_x = row_sums.s1 + x * row_sums.s0;
            sums.m00 += row_sums.s0;
            sums.m10 += along_x;
            sums.m01 += y * row_sums.s0;
            sums.m20 += row_sums.s2 + 2 * x * row_sums.s1 + x * x * row_sums.s0;
            sums.m11 += y * along_x;
            sums.m02 += y * y * row_sums.s0;
        }
        sums
    }
}

/// Sums along a row: of the weights, times x, and times x squared, with x counted from the row's first pixel.
#[derive(Default)]
struct RowSums {
    s0: u64,
    s1: u64,
    s2: u64,
}

/// Pixels per chunk: 32 bits hold a chunk's sums, which allows vector instructions.
const CHUNK: usize = 64;

impl RowSums {
    fn new(row: &[u8]) -> Self {
        let mut sums = Self::default();
        let (chunks, rest) = row.as_chunks::<CHUNK>();
        let mut start = 0;
        for chunk in chunks {
            sums.add(start, chunk);
            start += CHUNK as u64;
        }
        let mut padded = [0; CHUNK];
        padded[..rest.len()].copy_from_slice(rest);
        sums.add(start, &padded);
        sums
    }

    fn add(&mut self, start: u64, chunk: &[u8; CHUNK]) {
        // Products of 16-bit numbers summed in 32 bits, which vector instructions compute in parallel.
        let (mut c0, mut c1, mut c2) = (0i32, 0i32, 0i32);
        for ((&weight, &offset), &square) in chunk.iter().zip(&OFFSETS).zip(&SQUARES) {
            let weight = i32::from(weight);
            c0 += weight;
            c1 += weight * i32::from(offset);
            c2 += weight * i32::from(square);
        }
        // No sum is negative, so the casts are lossless.
        let (c0, c1, c2) = (c0 as u64, c1 as u64, c2 as u64);
        self.s0 += c0;
        self.s1 += c1 + start * c0;
        self.s2 += c2 + 2 * start * c1 + start * start * c0;
    }
}

/// Offset of each pixel in its chunk, and its square.
static OFFSETS: [i16; CHUNK] = offset_powers(1);
static SQUARES: [i16; CHUNK] = offset_powers(2);

const fn offset_powers(power: u32) -> [i16; CHUNK] {
    let mut offset_powers = [0; CHUNK];
    let mut i = 0;
    while i < CHUNK {
        offset_powers[i] = (i as i16).pow(power);
        i += 1;
    }
    offset_powers
}
