//! The canvas of a scene: three planes of numbers with a margin, so that blur needs no border cases, and the
//! effects of optics and sensor on them.

use barrelman_vocab::rng;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{Picture, PictureSize, PixelBox};

use super::colour::Yuv;

/// Margin in luma px: room for half of the longest motion blur and for the widest lens blur.
pub(super) const MARGIN: usize = 16;
/// Longest motion blur, px: 25 px a frame with the shutter open for 0.4 of it.
const MAX_BLUR_PX: f64 = 12.0;
/// Reach of the lens blur, px: 2.6 standard deviations of the widest.
const BLUR_REACH: usize = 4;
/// Samples per pixel and axis of an object's silhouette.
const SAMPLES: usize = 4;
/// Times of a pixel's samples during the exposure; neighbours have different times.
const EXPOSURE_ORDER: [u8; SAMPLES * SAMPLES] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
/// Length of the noise table; each row starts at another position.
const NOISE_LENGTH: usize = 1 << 16;
/// Colour encoding of the pictures.
pub(super) const COLOUR: ColourEncoding =
    ColourEncoding { matrix: ColourMatrix::Bt709, range: SampleRange::Limited };

/// A plane with its margin.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) samples: Vec<f32>,
}

impl Field {
    fn new(width: usize, height: usize) -> Self {
        Self { width, height, samples: vec![0.0; width * height] }
    }
}

/// Properties of the sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sensor {
    /// Brightness of the scene, about 1.
    pub(super) light: f32,
    /// Factor of the chroma.
    pub(super) saturation: f32,
    /// Standard deviation of the noise in luma and chroma, sample values.
    pub(super) noise: [f32; 2],
}

#[derive(Debug, Clone)]
pub(super) struct Canvas {
    size: PictureSize,
    pub(super) y: Field,
    /// Half as wide and high as `y`, margin included.
    pub(super) u: Field,
    pub(super) v: Field,
    scratch: Vec<f32>,
    noise: Vec<f32>,
}

impl Canvas {
    pub(super) fn new(size: PictureSize, seed: u64) -> Self {
        let even = |side: u32| side.div_ceil(2) as usize * 2 + 2 * MARGIN;
        let (width, height) = (even(size.width), even(size.height));
        let chroma = Field::new(width / 2, height / 2);
        let normal = |at: usize| {
            // The sum of four uniform numbers is close enough to a normal distribution.
            let bits = rng::hash(seed, 0, at as u64);
            let sum: u64 = (0..4).map(|part| (bits >> (16 * part)) & 0xFFFF).sum();
            ((sum as f64 / 65_535.0 - 2.0) * libm::sqrt(3.0)) as f32
        };
        let noise = (0..NOISE_LENGTH + width).map(normal).collect();
        Self {
            size,
            y: Field::new(width, height),
            u: chroma.clone(),
            v: chroma,
            scratch: vec![0.0; width * height],
            noise,
        }
    }

    /// Paints an object. `colour` gives the object's colour at a point of the picture (u, v), if the object
    /// covers it. The object moves by `motion` px during the exposure; `around` contains it at the middle of
    /// the exposure.
    pub(super) fn paint(
        &mut self,
        around: PixelBox,
        motion: (f64, f64),
        colour: impl Fn(f64, f64) -> Option<Yuv>,
    ) {
        let margin = MARGIN as f64;
        let reach = |low: f64, extent: f64, motion: f64, end: usize| {
            let begin = ((low + margin - motion.abs() / 2.0 - 1.0) / 2.0).floor().clamp(0.0, end as f64);
            let until =
                ((low + extent + margin + motion.abs() / 2.0 + 1.0) / 2.0).ceil().clamp(0.0, end as f64);
            begin as usize..until as usize
        };
        let columns = reach(around.u, around.w, motion.0, self.u.width);
        for row in reach(around.v, around.h, motion.1, self.u.height) {
            for column in columns.clone() {
                let mut chroma = [0.0_f32; 3];
                for (du, dv) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (x, y) = (2 * column + du, 2 * row + dv);
                    let [luma, u, v, cover] =
                        pixel_mean(x as f64 - margin, y as f64 - margin, motion, &colour);
                    let sample = &mut self.y.samples[y * self.y.width + x];
                    *sample += luma - *sample * cover;
                    chroma[0] += u / 4.0;
                    chroma[1] += v / 4.0;
                    chroma[2] += cover / 4.0;
                }
                let at = row * self.u.width + column;
                let [u, v, cover] = chroma;
                self.u.samples[at] += u - self.u.samples[at] * cover;
                self.v.samples[at] += v - self.v.samples[at] * cover;
            }
        }
    }

    /// Blurs everything painted so far along a motion, px.
    pub(super) fn motion_blur(&mut self, motion: (f64, f64)) {
        let length = libm::hypot(motion.0, motion.1);
        let scale_limit = (MAX_BLUR_PX / length.max(1e-9)).min(1.0);
        for (field, scale) in
            [(&mut self.y, scale_limit), (&mut self.u, scale_limit / 2.0), (&mut self.v, scale_limit / 2.0)]
        {
            motion_blur(field, &mut self.scratch, (motion.0 * scale, motion.1 * scale));
        }
    }

    /// Lens blur with this standard deviation in luma px. Chroma is blurred again by the filter before
    /// subsampling.
    pub(super) fn blur(&mut self, sigma_px: f64) {
        blur(&mut self.y, &mut self.scratch, sigma_px);
        let chroma = libm::hypot(sigma_px / 2.0, 0.5);
        blur(&mut self.u, &mut self.scratch, chroma);
        blur(&mut self.v, &mut self.scratch, chroma);
    }

    /// The sensor's picture; `seed` differs from frame to frame.
    pub(super) fn expose(&self, sensor: Sensor, seed: u64, out: &mut Picture) {
        out.reshape(self.size, COLOUR);
        let chroma = out.chroma_size();
        let sizes = [self.size, chroma, chroma];
        let fields = [&self.y, &self.u, &self.v];
        for (plane, samples) in out.planes_mut().into_iter().enumerate() {
            let (field, size) = (fields[plane], sizes[plane]);
            let (zero, low, high) = if plane == 0 { (16.0, 16.0, 235.0) } else { (128.0, 16.0, 240.0) };
            let (margin, std_dev) =
                if plane == 0 { (MARGIN, sensor.noise[0]) } else { (MARGIN / 2, sensor.noise[1]) };
            let gain = if plane == 0 { sensor.light } else { sensor.light * sensor.saturation };
            for (row, line) in samples.chunks_exact_mut(size.width as usize).enumerate() {
                let from = &field.samples[(row + margin) * field.width + margin..];
                let noise_start = rng::hash(seed, plane as u64, row as u64) as usize % NOISE_LENGTH;
                for ((sample, rendered), grain) in line.iter_mut().zip(from).zip(&self.noise[noise_start..]) {
                    let value = zero + (rendered - zero) * gain + std_dev * grain;
                    *sample = (value.clamp(low, high) + 0.5) as u8;
                }
            }
        }
    }
}

/// Mean of a pixel's samples over its area and the exposure: Y, U, V times the opacity, and the opacity.
fn pixel_mean(u: f64, v: f64, motion: (f64, f64), colour: &impl Fn(f64, f64) -> Option<Yuv>) -> [f32; 4] {
    let mut sum = [0.0_f32; 4];
    let step = 1.0 / SAMPLES as f64;
    for (sample, time) in EXPOSURE_ORDER.iter().enumerate() {
        let (column, row) = (sample % SAMPLES, sample / SAMPLES);
        let elapsed = (f64::from(*time) + 0.5) / (SAMPLES * SAMPLES) as f64 - 0.5;
        let u = u + (column as f64 + 0.5) * step - motion.0 * elapsed;
        let v = v + (row as f64 + 0.5) * step - motion.1 * elapsed;
        if let Some(colour) = colour(u, v) {
            for (sum, part) in sum.iter_mut().zip([colour[0], colour[1], colour[2], 1.0]) {
                *sum += part;
            }
        }
    }
    sum.map(|sum| sum / (SAMPLES * SAMPLES) as f32)
}

/// Mean of copies shifted by whole px along the motion. The outermost rows and columns stay.
fn motion_blur(field: &mut Field, scratch: &mut [f32], motion: (f64, f64)) {
    let extent = motion.0.abs().max(motion.1.abs());
    if extent < 0.5 {
        return;
    }
    let copies = extent.ceil() as usize + 1;
    let (width, height) = (field.width, field.height);
    let edge = (extent / 2.0).ceil() as usize + 1;
    scratch[..width * height].copy_from_slice(&field.samples);
    let share = 1.0 / copies as f32;
    for row in edge..height - edge {
        let line = &mut field.samples[row * width + edge..][..width - 2 * edge];
        line.fill(0.0);
        for copy in 0..copies {
            let along = copy as f64 / (copies - 1) as f64 - 0.5;
            let (du, dv) = ((motion.0 * along).round() as isize, (motion.1 * along).round() as isize);
            let from = ((row as isize + dv) * width as isize + edge as isize + du) as usize;
            for (sum, sample) in line.iter_mut().zip(&scratch[from..]) {
                *sum += sample * share;
            }
        }
    }
}

/// A separable Gaussian. The outermost rows and columns stay.
fn blur(field: &mut Field, scratch: &mut [f32], sigma: f64) {
    let mut weights = [0.0_f32; BLUR_REACH + 1];
    for (at, weight) in weights.iter_mut().enumerate() {
        *weight = libm::exp(-0.5 * (at * at) as f64 / (sigma * sigma)) as f32;
    }
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
    let [w0, w1, w2, w3, w4] = weights.map(|weight| weight / total);
    let (width, height) = (field.width, field.height);
    for row in BLUR_REACH..height - BLUR_REACH {
        let line = |offset: usize| &field.samples[(row + offset - BLUR_REACH) * width..][..width];
        let lines: [&[f32]; 2 * BLUR_REACH + 1] = core::array::from_fn(line);
        let out = &mut scratch[row * width..][..width];
        for (column, out) in out.iter_mut().enumerate() {
            let at = |line: usize| lines[line][column];
            *out = w0 * at(4)
                + w1 * (at(3) + at(5))
                + w2 * (at(2) + at(6))
                + w3 * (at(1) + at(7))
                + w4 * (at(0) + at(8));
        }
    }
    for row in BLUR_REACH..height - BLUR_REACH {
        let line = &scratch[row * width..][..width];
        let out = &mut field.samples[row * width + BLUR_REACH..][..width - 2 * BLUR_REACH];
        for (out, near) in out.iter_mut().zip(line.windows(2 * BLUR_REACH + 1)) {
            *out = w0 * near[4]
                + w1 * (near[3] + near[5])
                + w2 * (near[2] + near[6])
                + w3 * (near[1] + near[7])
                + w4 * (near[0] + near[8]);
        }
    }
}
