//! Mixing a layer of red, green and blue into the samples of a YUV 4:2:0 picture.
//!
//! With opacity α (0 to 1) and the layer's premultiplied colour, a sample s becomes s (1 - α) + m · rgb + o α: m is
//! the row of the matrix for that plane, scaled to the range, and o the sample of no colour (16 or 0 in Y, 128 in U
//! and V). A chroma sample takes the mean of the up to four pixels that it serves. In whole numbers, in shares of
//! 255 x 256, rounded once.

use core::ops::Range;

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, LumaWeights, SampleRange};

use super::layer::{Layer, TILE};

/// One row of the matrix: shares of red, green and blue in 1/256, and the sample of no colour.
#[derive(Debug, Clone, Copy)]
struct Mix {
    red: i32,
    green: i32,
    blue: i32,
    none: i32,
}

/// What 255 in a sample at full opacity comes to.
const WHOLE: i32 = 255 * 256;

impl Mix {
    /// The rows for Y, U and V.
    fn of(colour: ColourEncoding) -> [Self; 3] {
        let LumaWeights { red, green, blue } = colour.matrix.luma_weights();
        let (luma_span, chroma_span, black) = match colour.range {
            SampleRange::Limited => (219.0, 224.0, 16),
            SampleRange::Full => (255.0, 255.0, 0),
        };
        let row = |span: f64, weights: [f64; 3], none: i32| {
            let [red, green, blue] = weights.map(|weight| (weight * span * 256.0).round() as i32);
            Self { red, green, blue, none }
        };
        let (u, v) = (0.5 / (1.0 - blue), 0.5 / (1.0 - red));
        [
            row(luma_span, [red, green, blue], black),
            row(chroma_span, [-red * u, -green * u, 0.5], 128),
            row(chroma_span, [0.5, -green * v, -blue * v], 128),
        ]
    }

    /// The sample with a colour laid over it. The colour and the opacity are sums over four pixels, or over as many
    /// as there are at the picture's edge.
    #[inline(always)]
    fn over(&self, sample: u8, [red, green, blue, opacity]: [i32; 4], pixels: i32) -> u8 {
        let kept = i32::from(sample) * (255 * pixels - opacity) + self.none * opacity;
        let laid = self.red * red + self.green * green + self.blue * blue;
        let whole = WHOLE * pixels;
        ((kept * 256 + laid + whole / 2) / whole).clamp(0, 255) as u8
    }

    /// The same for Y and one pixel. Nothing in it is below zero, and nothing branches: where the opacity is 0 it
    /// gives the sample back, so that whole rows go through it, many samples at once.
    #[inline(always)]
    fn over_one(&self, sample: u8, pixel: [u8; 4]) -> u8 {
        let [red, green, blue, opacity] = pixel.map(u32::from);
        let kept = u32::from(sample) * (255 - opacity) + self.none as u32 * opacity;
        let laid = self.red as u32 * red + self.green as u32 * green + self.blue as u32 * blue;
        // Below 2^16, where a multiplication and a shift divide exactly by 255.
        let shares = (kept * 256 + laid + WHOLE as u32 / 2) >> 8;
        ((shares * 0x8081) >> 23).min(255) as u8
    }
}

/// What becomes of every sample under one and the same pixel: washes and plates make most of what is drawn.
struct Table {
    pixel: [u8; 4],
    samples: [[u8; 256]; 3],
}

impl Table {
    fn of(pixel: [u8; 4], mixes: &[Mix; 3]) -> Self {
        let sum = pixel.map(i32::from);
        let samples = mixes.map(|mix| core::array::from_fn(|sample| mix.over(sample as u8, sum, 1)));
        Self { pixel, samples }
    }

    fn apply(&self, plane: usize, samples: &mut [u8]) {
        for sample in samples {
            *sample = self.samples[plane][usize::from(*sample)];
        }
    }
}

/// Mixes a layer into a picture of the same size. Only samples under pixels that are not transparent change.
pub(super) fn onto(layer: &Layer, picture: &mut Picture) {
    let (width, height) = (picture.size().width as usize, picture.size().height as usize);
    let chroma_width = picture.chroma_size().width as usize;
    let mixes = Mix::of(picture.colour());
    let mut table = Table::of([0; 4], &mixes);
    let planes = &mut picture.planes_mut();
    let (pixels, _) = layer.rgba().as_chunks::<4>();
    for (left, top) in layer.drawn_tiles() {
        let tile = Tile { columns: left..(left + TILE).min(width), rows: top..(top + TILE).min(height) };
        let first = pixels[top * width + left];
        if !tile.rows.clone().all(|row| tile.of_row(pixels, row, width).iter().all(|pixel| *pixel == first)) {
            tile.blend(pixels, width, planes, &mixes);
            continue;
        }
        if first[3] == 0 {
            continue;
        }
        if table.pixel != first {
            table = Table::of(first, &mixes);
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

/// A part of the picture that begins at an even column and row.
struct Tile {
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Tile {
    fn of_row<'p>(&self, pixels: &'p [[u8; 4]], row: usize, width: usize) -> &'p [[u8; 4]] {
        &pixels[row * width..][self.columns.clone()]
    }

    /// Mixes the pixels over the tile's samples, each on its own.
    fn blend(&self, pixels: &[[u8; 4]], width: usize, [y, u, v]: &mut [&mut [u8]; 3], mixes: &[Mix; 3]) {
        let [y_mix, u_mix, v_mix] = mixes;
        for row in self.rows.clone() {
            let samples = &mut y[row * width..][self.columns.clone()];
            for (sample, pixel) in samples.iter_mut().zip(self.of_row(pixels, row, width)) {
                *sample = y_mix.over_one(*sample, *pixel);
            }
        }
        for row in self.rows.clone().step_by(2) {
            let upper = self.of_row(pixels, row, width);
            // The last row of an odd number of rows has none below it.
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
                    // The same with a constant number of pixels: no division is left.
                    (*u, *v) = (u_mix.over(*u, sum, 4), v_mix.over(*v, sum, 4));
                } else {
                    let pixels = (pair.len() + below.len()) as i32;
                    (*u, *v) = (u_mix.over(*u, sum, pixels), v_mix.over(*v, sum, pixels));
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
