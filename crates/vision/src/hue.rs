//! The hue of pixels that come as Y, U and V.
//!
//! A pixel's red, green and blue R, G, B (0 to 255) follow from its samples by the picture's matrix and range,
//! rounded and clipped. In the hexcone (Smith 1978) its value is V = max(R, G, B), its chroma
//! C = V - min(R, G, B), its saturation S = 255 C / V, and its hue H = 60 degrees times (G - B)/C where red is the
//! largest, 2 + (B - R)/C where green is, 4 + (R - G)/C where blue is, on a circle of 360 degrees. The *code* of a
//! pixel is H / 2 degrees rounded, 0 to 179 (red lies at both ends), or [`BELOW_FLOORS`] where its saturation or its
//! value is too low for the hue to mean anything. These are OpenCV's 8-bit hue, saturation and value of the same
//! picture turned into red, green and blue; the fixtures hold the two together.
//!
//! Only the pixels asked for are converted, a few at a stretch. Each takes the same few dozen operations, whatever
//! its colour, without a branch, so that the compiler can do several at once: whole numbers in 1/64 of a level for
//! the conversion, and single-precision additions, products and one division, which IEEE 754 rounds the same way
//! everywhere, for the hue.
//!
//! Chroma samples are not interpolated: the four pixels of a 2 x 2 block share one.

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};

use crate::window::Window;

/// Number of hues: codes 0 to 179, each two degrees wide.
pub(crate) const HUES: u8 = 180;

/// Code of a pixel whose hue does not count.
pub const BELOW_FLOORS: u8 = 255;

/// Least saturation and value at which a hue counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Floors {
    /// Least saturation, 0 to 255.
    pub saturation: u8,
    /// Least value, 0 to 255.
    pub value: u8,
}

/// Pixels converted at a stretch: even, as two share a chroma sample.
const STRETCH: usize = 32;

/// Bits behind the point in the sums that make red, green and blue.
const FRACTION: u32 = 6;
const ONE: f64 = (1 << FRACTION) as f64;

/// Converts the samples of one colour encoding into hue codes.
#[derive(Debug, Clone)]
pub struct HueOfYuv {
    colour: ColourEncoding,
    /// Levels per step of Y, in 1/2^14.
    luma_gain: u16,
    /// What V adds to red, in 1/64 of a level, with black's level and half a level for rounding taken in.
    red_of_v: [i16; 256],
    /// What U adds to green; black's level and the rounding are in here.
    green_of_u: [i16; 256],
    green_of_v: [i16; 256],
    blue_of_u: [i16; 256],
}

impl HueOfYuv {
    /// For pictures of this encoding.
    pub fn new(colour: ColourEncoding) -> Self {
        // Shares of red and blue in luma, from the recommendations of these numbers.
        let (red, blue) = match colour.matrix {
            ColourMatrix::Bt601 => (0.299, 0.114),
            ColourMatrix::Bt709 => (0.2126, 0.0722),
        };
        let green = 1.0 - red - blue;
        let (luma_scale, chroma_scale, black) = match colour.range {
            SampleRange::Limited => (255.0 / 219.0, 255.0 / 224.0, 16.0),
            SampleRange::Full => (1.0, 1.0, 0.0),
        };
        // The product with the gain is cut off, not rounded: half a step in the mean where it is not whole.
        let cut = if luma_scale == 1.0 { 0.0 } else { 0.5 };
        let offset = 0.5 * ONE + cut - black * luma_scale * ONE;
        let table = |per_step: f64, offset: f64| {
            core::array::from_fn(|sample| {
                let levels = (sample as f64 - 128.0) * per_step * chroma_scale;
                (levels * ONE + offset).round() as i16
            })
        };
        Self {
            colour,
            luma_gain: (luma_scale * f64::from(1 << 14)).round() as u16,
            red_of_v: table(2.0 * (1.0 - red), offset),
            green_of_u: table(-2.0 * (1.0 - blue) * blue / green, offset),
            green_of_v: table(-2.0 * (1.0 - red) * red / green, 0.0),
            blue_of_u: table(2.0 * (1.0 - blue), offset),
        }
    }

    /// The encoding that it was made for.
    pub const fn colour(&self) -> ColourEncoding {
        self.colour
    }

    /// Hands the codes of all pixels of `window` that lie in the picture to `sink`, as runs along a row: the column
    /// and the row of the run's first pixel, and its codes. Every pixel comes once.
    pub fn codes(
        &self,
        picture: &Picture,
        window: Window,
        floors: Floors,
        mut sink: impl FnMut(usize, usize, &[u8]),
    ) {
        let (luma, u_plane, v_plane) = (picture.y(), picture.u(), picture.v());
        let window = window.clipped(luma.width, luma.height);
        if window.is_empty() {
            return;
        }
        let mut codes = [0; STRETCH];
        for chroma_row in window.y / 2..window.bottom().div_ceil(2) {
            let (us, vs) = (u_plane.row(chroma_row), v_plane.row(chroma_row));
            let rows = (2 * chroma_row).max(window.y)..(2 * chroma_row + 2).min(window.bottom());
            // A window that starts in an odd column starts with the second half of a chroma sample.
            for x in (window.x & !1..window.right()).step_by(STRETCH) {
                let end = (x + STRETCH).min(window.right());
                let chroma = x / 2..end.div_ceil(2);
                let offsets = self.offsets(&us[chroma.clone()], &vs[chroma]);
                let first = x.max(window.x);
                for y in rows.clone() {
                    let samples = &luma.row(y)[x..end];
                    match samples.first_chunk() {
                        Some(samples) => self.stretch(samples, &offsets, floors, &mut codes),
                        None => {
                            let mut padded = [0; STRETCH];
                            padded[..samples.len()].copy_from_slice(samples);
                            self.stretch(&padded, &offsets, floors, &mut codes);
                        }
                    }
                    sink(first, y, &codes[first - x..end - x]);
                }
            }
        }
    }

    /// What the chroma samples of up to a stretch of pixels add to their red, green and blue.
    fn offsets(&self, us: &[u8], vs: &[u8]) -> Offsets {
        let mut offsets = Offsets { red: [0; STRETCH], green: [0; STRETCH], blue: [0; STRETCH] };
        for (i, (&u, &v)) in us.iter().zip(vs).enumerate().take(STRETCH / 2) {
            let (u, v) = (usize::from(u), usize::from(v));
            let green = self.green_of_u[u] + self.green_of_v[v];
            (offsets.red[2 * i], offsets.red[2 * i + 1]) = (self.red_of_v[v], self.red_of_v[v]);
            (offsets.green[2 * i], offsets.green[2 * i + 1]) = (green, green);
            (offsets.blue[2 * i], offsets.blue[2 * i + 1]) = (self.blue_of_u[u], self.blue_of_u[u]);
        }
        offsets
    }

    #[inline]
    fn stretch(&self, luma: &[u8; STRETCH], offsets: &Offsets, floors: Floors, codes: &mut [u8; STRETCH]) {
        let mut hexcone = Hexcone::default();
        for (i, &y) in luma.iter().enumerate() {
            let level = ((u32::from(u16::from(y) << 8) * u32::from(self.luma_gain)) >> 16) as i16;
            let channel = |offset: i16| (level.saturating_add(offset) >> FRACTION).clamp(0, 255);
            let (red, green, blue) =
                (channel(offsets.red[i]), channel(offsets.green[i]), channel(offsets.blue[i]));
            let value = red.max(green).max(blue);
            let (difference, sector) = if value == red {
                (green - blue, 0)
            } else if value == green {
                (blue - red, 60)
            } else {
                (red - green, 120)
            };
            hexcone.value[i] = value;
            hexcone.chroma[i] = value - red.min(green).min(blue);
            hexcone.difference[i] = difference;
            hexcone.sector[i] = sector;
        }
        hexcone.codes(floors, codes);
    }
}

struct Offsets {
    red: [i16; STRETCH],
    green: [i16; STRETCH],
    blue: [i16; STRETCH],
}

/// Pixels in the hexcone, before the division that makes the hue.
#[derive(Default)]
struct Hexcone {
    value: [i16; STRETCH],
    chroma: [i16; STRETCH],
    /// Difference of the two smaller channels, in the sense in which the hue grows.
    difference: [i16; STRETCH],
    /// Hue code at which the difference is 0.
    sector: [i16; STRETCH],
}

impl Hexcone {
    #[inline]
    fn codes(&self, floors: Floors, codes: &mut [u8; STRETCH]) {
        // S >= floor after rounding to the nearest whole number: 255 C / V >= floor - 1/2.
        let least_saturation = 2.0 * f32::from(floors.saturation) - 1.0;
        let least_value = f32::from(floors.value);
        for (i, code) in codes.iter_mut().enumerate() {
            let (value, chroma) = (f32::from(self.value[i]), f32::from(self.chroma[i]));
            let hue = f32::from(self.sector[i]) + 30.0 * f32::from(self.difference[i]) / chroma.max(1.0);
            // Within half a code below 0 it rounds to 0, and is put there: the trick below wants no negative numbers.
            let hue = if hue < -0.5 { hue + f32::from(HUES) } else { hue.max(0.0) };
            // Above 2^23 a float's last bit is worth 1, so that the sum rounds to a whole number; the hair before
            // it makes halves go up. It is far less than the distance of any other fraction from a half, 1/510.
            let rounded = ((hue + 1.0 / 2048.0) + 8_388_608.0).to_bits() as u8;
            let counts = value >= least_value && 510.0 * chroma >= least_saturation * value;
            *code = if counts { rounded } else { BELOW_FLOORS };
        }
    }
}
