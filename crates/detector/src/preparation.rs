//! A picture as a model takes it: its size, colours and scale.
//!
//! The picture is sampled bilinearly, luma and chroma at their own sizes, and converted to RGB.

use barrelman_vocab::video::{Picture, Plane};
use barrelman_vocab::{PictureSize, PixelBox};

use crate::settings::{ChannelOrder, InputLayout, InputSettings};

/// Grey of the bars beside a picture that keeps its aspect ratio, as is usual in training.
const BAR: f32 = 114.0;

/// Where the picture is in the input: input = picture * scale + offset, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    scale: [f64; 2],
    offset: [f64; 2],
}

impl Placement {
    pub(crate) fn new(picture: PictureSize, input: &InputSettings) -> Self {
        let (width, height) = (f64::from(picture.width), f64::from(picture.height));
        let sides = [input.width as f64, input.height as f64];
        let [across, down] = [sides[0] / width, sides[1] / height];
        if !input.letterbox {
            return Self { scale: [across, down], offset: [0.0; 2] };
        }
        let scale = across.min(down);
        let offset = [0.5 * (sides[0] - scale * width), 0.5 * (sides[1] - scale * height)];
        Self { scale: [scale; 2], offset }
    }

    /// A box of the input, by its centre and sides, in the picture. It may lie outside of the picture.
    pub(crate) fn in_picture(&self, [x, y, w, h]: [f64; 4]) -> PixelBox {
        PixelBox {
            u: (x - 0.5 * w - self.offset[0]) / self.scale[0],
            v: (y - 0.5 * h - self.offset[1]) / self.scale[1],
            w: w / self.scale[0],
            h: h / self.scale[1],
        }
    }

    /// The point of the picture that a pixel of the input shows; `None`: it is in a bar.
    fn source(&self, column: usize, row: usize, picture: PictureSize) -> Option<[f32; 2]> {
        let u = (column as f64 + 0.5 - self.offset[0]) / self.scale[0];
        let v = (row as f64 + 0.5 - self.offset[1]) / self.scale[1];
        let is_inside =
            (0.0..f64::from(picture.width)).contains(&u) && (0.0..f64::from(picture.height)).contains(&v);
        is_inside.then_some([u as f32, v as f32])
    }
}

/// Fills the model's input with a picture.
pub(crate) fn prepare(picture: &Picture, input: &InputSettings, values: &mut [f32]) -> Placement {
    let size = picture.size();
    let placement = Placement::new(size, input);
    let converter = Converter::new(picture);
    let area = input.width * input.height;
    for row in 0..input.height {
        for column in 0..input.width {
            let rgb = placement.source(column, row, size).map_or([BAR; 3], |at| converter.rgb_at(at));
            let pixel = row * input.width + column;
            for (channel, (mean, std)) in input.mean.iter().zip(&input.std).enumerate() {
                let sample = match input.channels {
                    ChannelOrder::Rgb => rgb[channel],
                    ChannelOrder::Bgr => rgb[2 - channel],
                };
                let index = match input.layout {
                    InputLayout::Nchw => channel * area + pixel,
                    InputLayout::Nhwc => 3 * pixel + channel,
                };
                if let Some(value) = values.get_mut(index) {
                    *value = (sample * input.scale - mean) / std;
                }
            }
        }
    }
    placement
}

/// Converts samples to red, green and blue, 0 to 255.
struct Converter<'a> {
    planes: [Plane<'a>; 3],
    /// Samples of the chroma planes for one of luma, across and down.
    chroma: [f32; 2],
    black: f32,
    luma_scale: f32,
    chroma_scale: f32,
    red_of_cr: f32,
    blue_of_cb: f32,
    weights: [f32; 3],
}

impl<'a> Converter<'a> {
    fn new(picture: &'a Picture) -> Self {
        let (size, chroma) = (picture.size(), picture.chroma_size());
        let weights = picture.colour().matrix.luma_weights();
        let scale = picture.colour().range.full_scale();
        Self {
            planes: [picture.y(), picture.u(), picture.v()],
            chroma: [chroma.width as f32 / size.width as f32, chroma.height as f32 / size.height as f32],
            black: scale.black as f32,
            luma_scale: scale.luma as f32,
            chroma_scale: scale.chroma as f32,
            red_of_cr: weights.cr_divisor() as f32,
            blue_of_cb: weights.cb_divisor() as f32,
            weights: [weights.red as f32, weights.green as f32, weights.blue as f32],
        }
    }

    fn rgb_at(&self, [u, v]: [f32; 2]) -> [f32; 3] {
        let chroma = [u * self.chroma[0], v * self.chroma[1]];
        let luma = (bilinear(&self.planes[0], [u, v]) - self.black) * self.luma_scale;
        let [_, blue_plane, red_plane] = &self.planes;
        let [cb, cr] =
            [blue_plane, red_plane].map(|plane| (bilinear(plane, chroma) - 128.0) * self.chroma_scale);
        let (red, blue) = (luma + self.red_of_cr * cr, luma + self.blue_of_cb * cb);
        let [of_red, of_green, of_blue] = self.weights;
        let green = (luma - of_red * red - of_blue * blue) / of_green;
        [red, green, blue].map(|value| value.clamp(0.0, 255.0))
    }
}

/// The value at a point; the centre of the first sample is at (0.5, 0.5).
fn bilinear(plane: &Plane<'_>, [u, v]: [f32; 2]) -> f32 {
    let (left, right, across) = neighbours(u, plane.width);
    let (upper, lower, down) = neighbours(v, plane.height);
    let (above, below) = (plane.row(upper), plane.row(lower));
    let mix = |from: f32, to: f32, share: f32| from + (to - from) * share;
    let in_row = |row: &[u8]| mix(f32::from(row[left]), f32::from(row[right]), across);
    mix(in_row(above), in_row(below), down)
}

/// The samples on both sides of a coordinate, and the share of the second.
fn neighbours(at: f32, count: usize) -> (usize, usize, f32) {
    let last = count.saturating_sub(1);
    let at = (at - 0.5).clamp(0.0, last as f32);
    let first = (at as usize).min(last);
    (first, (first + 1).min(last), at - first as f32)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::video::{ColourEncoding, SampleRange};

    use super::*;
    use crate::settings::Settings;

    /// A picture of one colour, with a brighter right half.
    fn picture([y, u, v]: [u8; 3], right: u8) -> Picture {
        let mut picture = Picture::black(PictureSize::new(64, 32), ColourEncoding::JPEG);
        let [luma, blue, red] = picture.planes_mut();
        for row in luma.chunks_mut(64) {
            row[..32].fill(y);
            row[32..].fill(right);
        }
        blue.fill(u);
        red.fill(v);
        picture
    }

    fn input(keys: &str) -> InputSettings {
        let text = format!(
            "classes = [\"boat\"]\n[input]\nwidth = 16\nheight = 16\n{keys}\n[output]\nformat = \"yolo\"\n"
        );
        Settings::from_toml(&text).unwrap().input
    }

    fn prepared(picture: &Picture, keys: &str) -> (Vec<f32>, Placement) {
        let input = input(keys);
        let mut values = vec![-1.0; 3 * 16 * 16];
        let placement = prepare(picture, &input, &mut values);
        (values, placement)
    }

    /// Red, in JPEG's colours.
    const RED: [u8; 3] = [76, 85, 255];

    #[track_caller]
    fn assert_near(values: [f32; 3], expected: [f32; 3]) {
        for (value, expected) in values.iter().zip(expected) {
            // Samples are rounded to whole numbers.
            assert!((value - expected).abs() < 2.0, "{values:?}");
        }
    }

    #[test]
    fn channels_and_axes_are_in_the_order_of_the_settings() {
        let red = picture(RED, RED[0]);
        let whole = "scale = 1.0\nletterbox = false";
        let (planes, _) = prepared(&red, whole);
        assert_near([planes[0], planes[256], planes[512]], [255.0, 0.0, 0.0]);
        let (planes, _) = prepared(&red, &format!("{whole}\nchannels = \"bgr\""));
        assert_near([planes[0], planes[256], planes[512]], [0.0, 0.0, 255.0]);
        let (pixels, _) = prepared(&red, &format!("{whole}\nlayout = \"nhwc\""));
        assert_near([pixels[3], pixels[4], pixels[5]], [255.0, 0.0, 0.0]);
    }

    #[test]
    fn scale_mean_and_deviation_are_applied_in_this_order() {
        let keys = "scale = 0.5\nmean = [10.0, 20.0, 30.0]\nstd = [2.0, 4.0, 8.0]\nletterbox = false";
        let (values, _) = prepared(&picture([100, 128, 128], 100), keys);
        for (value, expected) in [values[0], values[256], values[512]].iter().zip([20.0, 7.5, 2.5]) {
            // The conversion of colours rounds.
            assert!((value - expected).abs() < 1e-4, "{value}, not {expected}");
        }
    }

    #[test]
    fn a_picture_keeps_its_aspect_ratio_between_grey_bars() {
        let (values, placement) = prepared(&picture([0, 128, 128], 200), "scale = 1.0");
        assert_eq!(placement, Placement { scale: [0.25; 2], offset: [0.0, 4.0] });
        let row = |row: usize| [values[16 * row], values[16 * row + 15]];
        assert_eq!([row(3), row(4), row(11), row(12)], [[BAR; 2], [0.0, 200.0], [0.0, 200.0], [BAR; 2]]);
        let bounds = placement.in_picture([8.0, 8.0, 4.0, 2.0]);
        assert_eq!(bounds, PixelBox { u: 24.0, v: 12.0, w: 16.0, h: 8.0 });
    }

    #[test]
    fn a_limited_range_is_stretched() {
        let mut encoding = ColourEncoding::JPEG;
        encoding.range = SampleRange::Limited;
        let mut picture = Picture::black(PictureSize::new(16, 16), encoding);
        let [luma, blue, red] = picture.planes_mut();
        luma.fill(235);
        blue.fill(128);
        red.fill(128);
        let (values, _) = prepared(&picture, "scale = 1.0");
        assert_near([values[0], values[256], values[512]], [255.0; 3]);
    }
}
