//! Mixing a layer of red, green and blue into the samples of a YUV 4:2:0 picture.
//!
//! With opacity α (0 to 1) and the layer's premultiplied colour, a sample s becomes s (1 - α) + m · rgb + o α: m is
//! the row of the matrix for that plane, scaled to the range, and o the sample of no colour (16 or 0 in Y, 128 in U
//! and V). A chroma sample takes the mean of the up to four pixels that it serves. In whole numbers, in shares of
//! 255 x 256, rounded once.

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};

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
        // Luma weights of red and blue: ITU-R BT.601-7, section 2.5.1, and BT.709-6, section 3.2.
        let (red, blue) = match colour.matrix {
            ColourMatrix::Bt601 => (0.299, 0.114),
            ColourMatrix::Bt709 => (0.2126, 0.0722),
        };
        let green = 1.0 - red - blue;
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

    /// The sample with a colour laid over it. The colour and the opacity are sums over `pixels` pixels.
    #[inline(always)]
    fn over(&self, sample: u8, [red, green, blue, opacity]: [i32; 4], pixels: i32) -> u8 {
        let kept = i32::from(sample) * (255 * pixels - opacity) + self.none * opacity;
        let laid = self.red * red + self.green * green + self.blue * blue;
        let whole = WHOLE * pixels;
        ((kept * 256 + laid + whole / 2) / whole).clamp(0, 255) as u8
    }
}

/// Mixes a layer into a picture of the same size. Only samples under pixels that are not transparent change.
pub(super) fn onto(layer: &Layer, picture: &mut Picture) {
    let (width, height) = (picture.size().width as usize, picture.size().height as usize);
    let chroma_width = picture.chroma_size().width as usize;
    let [y_mix, u_mix, v_mix] = Mix::of(picture.colour());
    let [y, u, v] = picture.planes_mut();
    let rgba = layer.rgba();
    for (left, top) in layer.drawn_tiles() {
        let (right, bottom) = ((left + TILE).min(width), (top + TILE).min(height));
        for row in top..bottom {
            let samples = &mut y[row * width + left..row * width + right];
            let pixels = rgba[(row * width + left) * 4..(row * width + right) * 4].chunks_exact(4);
            for (sample, pixel) in samples.iter_mut().zip(pixels) {
                if pixel[3] != 0 {
                    *sample = y_mix.over(*sample, sum_of(pixel), 1);
                }
            }
        }
        for row in (top..bottom).step_by(2) {
            for column in (left..right).step_by(2) {
                let (pair, rows) = ((right - column).min(2), (bottom - row).min(2));
                let sum = (row..row + rows).fold([0; 4], |sum, row| {
                    let pixels = &rgba[(row * width + column) * 4..][..pair * 4];
                    pixels.chunks_exact(4).fold(sum, |sum, pixel| plus(sum, sum_of(pixel)))
                });
                if sum[3] != 0 {
                    let chroma = row / 2 * chroma_width + column / 2;
                    let pixels = (pair * rows) as i32;
                    u[chroma] = u_mix.over(u[chroma], sum, pixels);
                    v[chroma] = v_mix.over(v[chroma], sum, pixels);
                }
            }
        }
    }
}

fn sum_of(pixel: &[u8]) -> [i32; 4] {
    [0, 1, 2, 3].map(|channel| i32::from(pixel[channel]))
}

fn plus(one: [i32; 4], other: [i32; 4]) -> [i32; 4] {
    [0, 1, 2, 3].map(|channel| one[channel] + other[channel])
}
