//! The practice clip: a red boat that crosses all four sectors of a picture of water, with exact truth.
//!
//! The clip stands in for a camera where none is attached, and tests of the control loop use it. Its camera
//! rests: commands do not change the picture. Waves, light and optics are not simulated.

use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{Angle, ImagePoint, Picture, PictureSize, PixelBox, PixelPoint};

use crate::noise;

/// Frames per second.
pub const FRAMES_PER_SECOND: u32 = 30;

/// Way-points as (time in seconds, x, y), x and y in shares of half the picture's width and height: out to
/// the right, top, left and bottom, and from the bottom into the right sector without returning to the
/// centre.
const WAY_POINTS: [(f64, f64, f64); 14] = [
    (0.0, 0.05, 0.00),
    (1.5, 0.10, 0.02),
    (4.0, 0.80, 0.05),
    (5.5, 0.62, -0.20),
    (7.0, 0.02, 0.05),
    (9.5, 0.12, 0.80),
    (11.5, 0.00, 0.05),
    (14.0, -0.80, 0.10),
    (16.0, -0.10, -0.05),
    (18.0, -0.06, -0.78),
    (19.5, 0.35, -0.80),
    (21.0, 0.80, -0.45),
    (23.0, 0.05, 0.00),
    (24.0, 0.02, 0.02),
];

/// The boat in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoatTruth {
    /// Centre of the hull in image coordinates, pixels.
    pub centre: ImagePoint,
    /// Direction of the bow, anticlockwise from image right.
    pub heading: Angle,
    /// Upright box around the hull, clipped to the picture.
    pub bounds: PixelBox,
    /// A box within the hull whatever its heading, for the operator's selection.
    pub selection: PixelBox,
}

/// The clip.
#[derive(Debug, Clone)]
pub struct PracticeClip {
    size: PictureSize,
    fine: Vec<u8>,
    coarse: Vec<u8>,
}

/// Hull length as a share of the picture's width.
const HULL_LENGTH_SHARE: f64 = 0.062;
/// Beam over hull length.
const BEAM_OVER_LENGTH: f64 = 0.42;
/// The heading is the direction from the position this long before to that this long after, seconds.
const HEADING_SMOOTHING_S: f64 = 0.35;

impl PracticeClip {
    /// A clip of this picture size; the seed determines the pattern of the water.
    pub fn new(size: PictureSize, seed: u64) -> Self {
        Self { size, fine: noise::tile(seed, 16), coarse: noise::tile(seed.wrapping_add(1), 64) }
    }

    /// Number of frames.
    pub fn frames(&self) -> u32 {
        (WAY_POINTS[WAY_POINTS.len() - 1].0 * f64::from(FRAMES_PER_SECOND)) as u32
    }

    /// Picture size.
    pub const fn size(&self) -> PictureSize {
        self.size
    }

    /// Colour encoding of the pictures.
    pub const fn colour(&self) -> ColourEncoding {
        ColourEncoding { matrix: ColourMatrix::Bt709, range: SampleRange::Limited }
    }

    /// The boat in a frame.
    pub fn truth(&self, frame: u32) -> BoatTruth {
        let t = f64::from(frame) / f64::from(FRAMES_PER_SECOND);
        let centre = self.position_at(t);
        let ahead = self.position_at(t + HEADING_SMOOTHING_S);
        let behind = self.position_at(t - HEADING_SMOOTHING_S);
        let heading = libm::atan2(ahead.y - behind.y, ahead.x - behind.x);
        let (half_length, half_beam) = self.half_hull();
        let (s, c) = (libm::sin(heading), libm::cos(heading));
        // The box of an ellipse contains the superellipse of the hull.
        let half_w = libm::hypot(half_length * c, half_beam * s);
        let half_h = libm::hypot(half_length * s, half_beam * c);
        let middle = centre.in_pixels(self.size);
        let bounds =
            PixelBox { u: middle.u - half_w, v: middle.v - half_h, w: 2.0 * half_w, h: 2.0 * half_h };
        let reach = half_beam * 0.8;
        let selection = PixelBox { u: middle.u - reach, v: middle.v - reach, w: 2.0 * reach, h: 2.0 * reach };
        BoatTruth {
            centre,
            heading: Angle::from_radians(heading),
            bounds: bounds.clipped(self.size),
            selection: selection.clipped(self.size),
        }
    }

    fn half_hull(&self) -> (f64, f64) {
        let half_length = HULL_LENGTH_SHARE * f64::from(self.size.width) / 2.0;
        (half_length, half_length * BEAM_OVER_LENGTH)
    }

    /// Position at a time (s), interpolated monotonically between the way-points so that the boat does not
    /// overshoot them.
    fn position_at(&self, t: f64) -> ImagePoint {
        let t = t.clamp(0.0, WAY_POINTS[WAY_POINTS.len() - 1].0);
        let next = WAY_POINTS.iter().position(|point| point.0 > t).unwrap_or(WAY_POINTS.len() - 1).max(1);
        let (from, to) = (WAY_POINTS[next - 1], WAY_POINTS[next]);
        let s = (t - from.0) / (to.0 - from.0);
        let ease = s * s * (3.0 - 2.0 * s);
        // Half linear, half eased: the boat slows down at the way-points without stopping.
        let share = 0.5 * (s + ease);
        let at = |a: f64, b: f64| a + (b - a) * share;
        ImagePoint {
            x: at(from.1, to.1) * f64::from(self.size.width) / 2.0,
            y: at(from.2, to.2) * f64::from(self.size.height) / 2.0,
        }
    }

    /// Renders a frame; the picture takes the clip's size and encoding.
    pub fn render(&self, frame: u32, picture: &mut Picture) {
        picture.reshape(self.size, self.colour());
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let drift = frame as usize;
        let mut planes = picture.planes_mut();
        for (row, line) in planes[0].chunks_exact_mut(width).enumerate() {
            let fine_row = ((row * 2 + drift) % noise::TILE_SIDE) * noise::TILE_SIDE;
            let coarse_row = ((row + noise::TILE_SIDE - drift / 3 % noise::TILE_SIDE) % noise::TILE_SIDE)
                * noise::TILE_SIDE;
            // Nearer water is slightly lighter.
            let base = 62 + (row * 14 / height) as i32;
            for (column, sample) in line.iter_mut().enumerate() {
                let fine = i32::from(self.fine[fine_row + (column + drift / 2) % noise::TILE_SIDE]);
                let coarse = i32::from(self.coarse[coarse_row + (column + drift) % noise::TILE_SIDE]);
                let ripple = (fine - 128) / 6 + (coarse - 128) / 5;
                let glint = (fine + coarse - 395).max(0) * 2;
                *sample = (base + ripple + glint).clamp(16, 235) as u8;
            }
        }
        planes[1].fill(138);
        planes[2].fill(112);
        self.render_wake(frame, &mut planes);
        self.render_boat(frame, &mut planes);
    }

    fn render_wake(&self, frame: u32, planes: &mut [&mut [u8]; 3]) {
        let (_, half_beam) = self.half_hull();
        let age_frames = 36_u32;
        for age in (3..age_frames).rev() {
            let Some(then) = frame.checked_sub(age) else { continue };
            let fade = 1.0 - f64::from(age) / f64::from(age_frames);
            let centre = self.truth(then).centre.in_pixels(self.size);
            let radius = half_beam * (0.55 + 0.9 * (1.0 - fade));
            self.blend(planes, centre, radius, |du, dv| {
                let share = 1.0 - (du * du + dv * dv) / (radius * radius);
                let grain = noise::unit(u64::from(then), 7, ((du as i64 * 64 + dv as i64) as u64) & 0xFFFF);
                ([200.0, 129.0, 124.0], (0.20 * fade * share.max(0.0) * (0.3 + grain)).min(1.0))
            });
        }
    }

    fn render_boat(&self, frame: u32, planes: &mut [&mut [u8]; 3]) {
        let truth = self.truth(frame);
        let (half_length, half_beam) = self.half_hull();
        let centre = truth.centre.in_pixels(self.size);
        let (s, c) = (libm::sin(truth.heading.radians()), libm::cos(truth.heading.radians()));
        self.blend(planes, centre, half_length + 2.0, |du, dv| {
            // Along and across the hull; v counts downwards.
            let along = (du * c - dv * s) / half_length;
            let across = (du * s + dv * c) / half_beam;
            // The bow is pointed, the stern blunt.
            let width = if along > 0.2 { 1.0 - 0.75 * (along - 0.2) * (along - 0.2) / 0.64 } else { 1.0 };
            let side = across / width.max(0.2);
            let edge = (along * along * along * along + (side * side) * (side * side)).sqrt();
            let opacity = ((1.0 - edge) * half_beam * 0.5 + 0.5).clamp(0.0, 1.0);
            let cockpit = along > -0.55 && along < 0.15 && across.abs() < 0.42;
            let colour = if cockpit { [96.0, 118.0, 168.0] } else { [74.0, 102.0, 214.0] };
            (colour, opacity)
        });
    }

    /// Blends a colour into the pixels around a centre. `paint` gives colour and opacity for each offset,
    /// pixels.
    fn blend(
        &self,
        planes: &mut [&mut [u8]; 3],
        centre: PixelPoint,
        reach: f64,
        paint: impl Fn(f64, f64) -> ([f64; 3], f64),
    ) {
        let span = |centre: f64, end: u32| {
            let low = (centre - reach).floor().clamp(0.0, f64::from(end)) as usize;
            let high = (centre + reach).ceil().clamp(0.0, f64::from(end)) as usize;
            low..high
        };
        let width = self.size.width as usize;
        let chroma_width = width.div_ceil(2);
        for row in span(centre.v, self.size.height) {
            for column in span(centre.u, self.size.width) {
                let (colour, opacity) = paint(column as f64 + 0.5 - centre.u, row as f64 + 0.5 - centre.v);
                if opacity <= 0.0 {
                    continue;
                }
                let mix = |sample: &mut u8, value: f64, opacity: f64| {
                    *sample = (f64::from(*sample) + opacity * (value - f64::from(*sample)) + 0.5) as u8;
                };
                mix(&mut planes[0][row * width + column], colour[0], opacity);
                // Four pixels share a chroma sample: four blends with this opacity equal one with the whole
                // opacity.
                let chroma = (row / 2) * chroma_width + column / 2;
                let share = 1.0 - libm::sqrt(libm::sqrt(1.0 - opacity));
                mix(&mut planes[1][chroma], colour[1], share);
                mix(&mut planes[2][chroma], colour[2], share);
            }
        }
    }
}
