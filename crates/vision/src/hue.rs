//! Hue of pixels given as Y, U and V.
//!
//! A pixel's red, green and blue R, G, B (0 to 255) follow from its samples by the picture's matrix and
//! range, rounded and clipped. In the hexcone model (Smith 1978) the value is V = max(R, G, B), the chroma C
//! = V - min(R, G, B), the saturation S = 255 C / V, and the hue H = 60 degrees times (G - B)/C where red is
//! the maximum, 2 + (B - R)/C where green is, 4 + (R - G)/C where blue is, on a circle of 360 degrees. The
//! *hue code* of a pixel is H / 2 degrees, rounded, 0 to 179 (red lies at both ends), or [`BELOW_FLOORS`]
//! where saturation or value are too low for a meaningful hue. This is OpenCV's 8-bit hue, saturation and
//! value of the same picture converted to RGB; the fixtures compare both.
//!
//! Integer and fixed-point arithmetic (1/65536 of a level) throughout, with the same result on every machine.
//! A conversion costs some nanoseconds, which is why the back projection uses a table.

use barrelman_vocab::video::{ColourEncoding, FullScale};

/// Number of hue codes: 0 to 179, two degrees each.
pub(crate) const HUE_CODES: u8 = 180;

/// Hue code of a pixel whose saturation or value lies below the floors.
pub const BELOW_FLOORS: u8 = 255;

/// Minimum saturation and value of a pixel whose hue counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Floors {
    /// Minimum saturation, 0 to 255.
    pub saturation: u8,
    /// Minimum value, 0 to 255.
    pub value: u8,
}

/// Fractional bits of the sums that give red, green and blue.
const FRACTION: u32 = 16;

/// Converts the samples of one colour encoding to hue codes.
#[derive(Debug, Clone)]
pub struct YuvToHue {
    colour: ColourEncoding,
    /// Level at Y = 0 plus half a level for rounding, in 1/65536 of a level.
    level_of_zero: i32,
    /// Levels per step of a sample, in 1/65536: Y for each channel, V for red and green, U for green and
    /// blue.
    per_y: i32,
    red_per_v: i32,
    green_per_u: i32,
    green_per_v: i32,
    blue_per_u: i32,
}

impl YuvToHue {
    /// A converter for pictures of this encoding.
    pub fn new(colour: ColourEncoding) -> Self {
        let weights = colour.matrix.luma_weights();
        let FullScale { luma: luma_scale, chroma: chroma_scale, black } = colour.range.full_scale();
        let fixed = |levels: f64| (levels * f64::from(1 << FRACTION)).round() as i32;
        let red_per_v = weights.cr_divisor() * chroma_scale;
        let blue_per_u = weights.cb_divisor() * chroma_scale;
        Self {
            colour,
            level_of_zero: fixed(0.5 - black * luma_scale),
            per_y: fixed(luma_scale),
            red_per_v: fixed(red_per_v),
            green_per_u: fixed(-blue_per_u * weights.blue / weights.green),
            green_per_v: fixed(-red_per_v * weights.red / weights.green),
            blue_per_u: fixed(blue_per_u),
        }
    }

    /// The encoding of the pictures.
    pub const fn colour(&self) -> ColourEncoding {
        self.colour
    }

    /// The hue code of a pixel.
    pub fn hue_code(&self, [y, u, v]: [u8; 3], floors: Floors) -> u8 {
        let (u, v) = (i32::from(u) - 128, i32::from(v) - 128);
        let level = self.level_of_zero + i32::from(y) * self.per_y;
        let channel = |offset: i32| ((level + offset) >> FRACTION).clamp(0, 255);
        let red = channel(v * self.red_per_v);
        let green = channel(u * self.green_per_u + v * self.green_per_v);
        let blue = channel(u * self.blue_per_u);

        let value = red.max(green).max(blue);
        let chroma = value - red.min(green).min(blue);
        // Rounded to the nearest, S >= floor where 255 C / V >= floor - 1/2.
        let saturated = 510 * chroma >= (2 * i32::from(floors.saturation) - 1) * value;
        if value < i32::from(floors.value) || !saturated {
            return BELOW_FLOORS;
        }
        if chroma == 0 {
            return 0;
        }
        let (sector, difference) = if value == red {
            (0, green - blue)
        } else if value == green {
            (60, blue - red)
        } else {
            (120, red - green)
        };
        // 30 difference / chroma, rounded to the nearest whole number.
        let within = (60 * difference + chroma).div_euclid(2 * chroma);
        // 0 to 179, so the cast is lossless.
        (sector + within).rem_euclid(i32::from(HUE_CODES)) as u8
    }
}
