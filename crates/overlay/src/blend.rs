//! Blends a layer of red, green and blue into the samples of a YUV 4:2:0 picture.
//!
//! With opacity α (0 to 1) and the layer's premultiplied colour, a sample s becomes s (1 - α) + m · rgb + o
//! α. Here m is the row of the matrix for the plane, scaled to the range, and o the sample of black (16 or 0
//! in Y, 128 in U and V). A chroma sample uses the mean of its up to four pixels. Integer arithmetic in units
//! of 1 / (255 x 256), rounded once.

use core::ops::Range;

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, LumaWeights, SampleRange};

use super::layer::{Layer, TILE};

/// One row of the matrix: weights of red, green and blue in 1/256, and the sample of black.
#[derive(Debug, Clone, Copy)]
struct MatrixRow {
    red: i32,
    green: i32,
    blue: i32,
    black: i32,
}

/// The value of a sample of 255 at full opacity, in the units of the blend.
const FULL_SCALE: i32 = 255 * 256;

impl MatrixRow {
    /// The rows for Y, U and V.
    fn for_encoding(colour: ColourEncoding) -> [Self; 3] {
        let LumaWeights { red, green, blue } = colour.matrix.luma_weights();
        let (luma_range, chroma_range, black) = match colour.range {
            SampleRange::Limited => (219.0, 224.0, 16),
            SampleRange::Full => (255.0, 255.0, 0),
        };
        let row = |range: f64, weights: [f64; 3], black: i32| {
            let [red, green, blue] = weights.map(|weight| (weight * range * 256.0).round() as i32);
            Self { red, green, blue, black }
        };
        let (u, v) = (0.5 / (1.0 - blue), 0.5 / (1.0 - red));
        [
            row(luma_range, [red, green, blue], black),
            row(chroma_range, [-red * u, -green * u, 0.5], 128),
            row(chroma_range, [0.5, -green * v, -blue * v], 128),
        ]
    }

    /// The sample blended with a colour. The colour and the opacity are sums over `pixels` pixels: four, or
    /// fewer at the picture's edge.
    #[inline(always)]
    fn blend(&self, sample: u8, [red, green, blue, opacity]: [i32; 4], pixels: i32) -> u8 {
        let kept = i32::from(sample) * (255 * pixels - opacity) + self.black * opacity;
        let added = self.red * red + self.green * green + self.blue * blue;
        let whole = FULL_SCALE * pixels;
        ((kept * 256 + added + whole / 2) / whole).clamp(0, 255) as u8
    }

    /// As [`Self::blend`] for Y and one pixel. All values are non-negative and there is no branch, so that
    /// the compiler vectorises a row; at opacity 0 the result is the sample.
    #[inline(always)]
    fn blend_luma(&self, sample: u8, pixel: [u8; 4]) -> u8 {
        let [red, green, blue, opacity] = pixel.map(u32::from);
        let kept = u32::from(sample) * (255 - opacity) + self.black as u32 * opacity;
        let added = self.red as u32 * red + self.green as u32 * green + self.blue as u32 * blue;
        // Below 2^16, where a multiplication and a shift divide exactly by 255.
        let shares = (kept * 256 + added + FULL_SCALE as u32 / 2) >> 8;
        ((shares * 0x8081) >> 23).min(255) as u8
    }
}

/// The blend of every sample value with one pixel. Most of a layer is areas of one colour.
struct LookupTable {
    pixel: [u8; 4],
    samples: [[u8; 256]; 3],
}

impl LookupTable {
    fn new(pixel: [u8; 4], rows: &[MatrixRow; 3]) -> Self {
        let sum = pixel.map(i32::from);
        let samples = rows.map(|row| core::array::from_fn(|sample| row.blend(sample as u8, sum, 1)));
        Self { pixel, samples }
    }

    fn apply(&self, plane: usize, samples: &mut [u8]) {
        for sample in samples {
            *sample = self.samples[plane][usize::from(*sample)];
        }
    }
}

/// Blends a layer into a picture of the same size. Only samples under pixels that are not transparent change.
pub(super) fn blend_layer(layer: &Layer, picture: &mut Picture) {
    let (width, height) = (picture.size().width as usize, picture.size().height as usize);
    let chroma_width = picture.chroma_size().width as usize;
    let rows = MatrixRow::for_encoding(picture.colour());
    let mut table = LookupTable::new([0; 4], &rows);
    let planes = &mut picture.planes_mut();
    let (pixels, _) = layer.rgba().as_chunks::<4>();
    for (left, top) in layer.drawn_tiles() {
        let tile = Tile { columns: left..(left + TILE).min(width), rows: top..(top + TILE).min(height) };
        let first = pixels[top * width + left];
        if !tile.rows.clone().all(|row| tile.of_row(pixels, row, width).iter().all(|pixel| *pixel == first)) {
            tile.blend(pixels, width, planes, &rows);
            continue;
        }
        if first[3] == 0 {
            continue;
        }
        if table.pixel != first {
            table = LookupTable::new(first, &rows);
        }
        let [y, u, v] = &mut *planes;
        for row in tile.rows.clone() {
            table.apply(0, &mut y[row * width..][tile.columns.clone()]);
        }
        for row in top / 2..tile.rows.end.div_ceil(2) {
            let columns = left / 2..tile.columns.end.div_ceil(2);
            table.apply(1, &mut u[row * chroma_width..][columns.clone()]);
            table.apply(2, &mut v[row * chroma_width..][columns]);
        }
    }
}

/// A part of the picture that starts at an even column and row.
struct Tile {
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Tile {
    fn of_row<'p>(&self, pixels: &'p [[u8; 4]], row: usize, width: usize) -> &'p [[u8; 4]] {
        &pixels[row * width..][self.columns.clone()]
    }

    /// Blends each pixel into the tile's samples.
    fn blend(&self, pixels: &[[u8; 4]], width: usize, [y, u, v]: &mut [&mut [u8]; 3], rows: &[MatrixRow; 3]) {
        let [y_row, u_row, v_row] = rows;
        for row in self.rows.clone() {
            let samples = &mut y[row * width..][self.columns.clone()];
            for (sample, pixel) in samples.iter_mut().zip(self.of_row(pixels, row, width)) {
                *sample = y_row.blend_luma(*sample, *pixel);
            }
        }
        for row in self.rows.clone().step_by(2) {
            let upper = self.of_row(pixels, row, width);
            // With an odd number of rows, the last row has no row below it.
            let lower = if row + 1 < self.rows.end { self.of_row(pixels, row + 1, width) } else { &[] };
            let chroma = row / 2 * width.div_ceil(2) + self.columns.start / 2;
            for (column, pair) in upper.chunks(2).enumerate() {
                let below = lower.get(column * 2..column * 2 + pair.len()).unwrap_or_default();
                let sum = sum_of(pair, below);
                if sum[3] == 0 {
                    continue;
                }
                let (u, v) = (&mut u[chroma + column], &mut v[chroma + column]);
                if pair.len() + below.len() == 4 {
                    // A constant number of pixels avoids the division.
                    (*u, *v) = (u_row.blend(*u, sum, 4), v_row.blend(*v, sum, 4));
                } else {
                    let pixels = (pair.len() + below.len()) as i32;
                    (*u, *v) = (u_row.blend(*u, sum, pixels), v_row.blend(*v, sum, pixels));
                }
            }
        }
    }
}

/// Sums of the channels over some pixels, at most four.
fn sum_of(upper: &[[u8; 4]], lower: &[[u8; 4]]) -> [i32; 4] {
    // Two channels at a time, 16 bits apart: a sum of four bytes does not reach the next one.
    let (mut red_and_blue, mut green_and_opacity) = (0, 0);
    for pixel in upper.iter().chain(lower) {
        let pixel = u32::from_le_bytes(*pixel);
        red_and_blue += pixel & 0x00FF_00FF;
        green_and_opacity += pixel >> 8 & 0x00FF_00FF;
    }
    let [low, high] = [0, 16].map(|shift| move |pair: u32| (pair >> shift & 0xFFFF) as i32);
    [low(red_and_blue), low(green_and_opacity), high(red_and_blue), high(green_and_opacity)]
}
