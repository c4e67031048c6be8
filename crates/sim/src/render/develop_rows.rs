//! From rows of light to samples: blur across rows, then the sensor, two rows at a time because they share
//! their chroma.

use barrelman_vocab::rng;

use super::light_rows::{BAND_ROWS, LightRows};
use super::sensor::{self, Development, MAX_TAPS, NoiseTable};
use super::view::FrameView;
use crate::pose::CameraAxes;

/// A picture that moves by less than this during the exposure gets no motion blur, pixels.
const MIN_BLUR_PX: f64 = 0.6;
/// Share of a pixel's light that the lens gives to each neighbour.
const LENS_SOFTNESS: f32 = 0.085;
/// Gain at which a sunlit scene is well exposed.
const EXPOSURE_GAIN: f32 = 1.45;

/// Samples of a band, and working memory for two rows.
#[derive(Debug)]
pub(super) struct SampleBand {
    pub(super) y: Vec<u8>,
    pub(super) u: Vec<u8>,
    pub(super) v: Vec<u8>,
    /// Red, green and blue of the upper row, then of the lower row.
    rows: [Vec<f32>; 6],
    scratch: Vec<f32>,
}

impl SampleBand {
    pub(super) fn new(width: usize) -> Self {
        Self {
            y: vec![0; BAND_ROWS * width],
            u: vec![0; BAND_ROWS * width / 4],
            v: vec![0; BAND_ROWS * width / 4],
            rows: core::array::from_fn(|_| vec![0.0; width]),
            scratch: vec![0.0; width],
        }
    }
}

/// By how much the picture moves during the exposure because the camera turns, pixels (right, down).
pub(super) fn motion_blur_px(view: &FrameView<'_>) -> (f64, f64) {
    let height = view.settings.optics.picture.height as usize;
    let (first, last) = (view.camera.row(0), view.camera.row(height - 1));
    let ahead = view.camera.row(height / 2).axes.ahead;
    let project = |axes: &CameraAxes| {
        view.settings.optics.project((ahead.dot(axes.right), ahead.dot(axes.down), ahead.dot(axes.ahead)))
    };
    match (project(&first.axes), project(&last.axes)) {
        (Some(a), Some(b)) if view.settings.readout_s > 0.0 => {
            let part = view.snapshot.sensor.exposure_s / view.settings.readout_s;
            ((b.u - a.u) * part, (b.v - a.v) * part)
        }
        _ => (0.0, 0.0),
    }
}

/// Develops a row and the next one.
pub(super) fn develop_two_rows(
    view: &FrameView<'_>,
    (light, noise_table): (&LightRows, &NoiseTable),
    blur: (f64, f64),
    row: usize,
    samples: &mut SampleBand,
) {
    blur_two_rows(view, light, blur, row, samples);
    let simd = view.settings.simd;
    let size = view.settings.optics.picture;
    let (width, height) = (size.width as usize, size.height as usize);
    let state = &view.snapshot.sensor;
    let diagonal = libm::hypot(width as f64, height as f64);
    let gain = state.exposure as f32 * EXPOSURE_GAIN;
    let step = (2.0 / diagonal) as f32;
    let development = |row: usize| Development {
        gains: [gain * state.red as f32, gain, gain * state.blue as f32],
        y: (row as f32 + 0.5 - 0.5 * height as f32) * step,
        x0: (0.5 - 0.5 * width as f32) * step,
        step,
        noise: if view.settings.effects.noise { 1.0 } else { 0.0 },
    };
    let noise_row = |stream: u64, row: usize| {
        let random = rng::hash(view.settings.seed ^ view.snapshot.tick, stream, row as u64);
        noise_table.row(random, width)
    };
    let (upper_row, lower_row) = (development(row), development(row + 1));
    let [r0, g0, b0, r1, g1, b1] = &mut samples.rows;
    sensor::develop(simd, &upper_row, [r0, g0, b0]);
    sensor::develop(simd, &lower_row, [r1, g1, b1]);
    let local = row % BAND_ROWS;
    let (upper, lower) = samples.y[local * width..][..2 * width].split_at_mut(width);
    sensor::luma(simd, &upper_row, [r0, g0, b0], noise_row(1, row), upper);
    sensor::luma(simd, &lower_row, [r1, g1, b1], noise_row(1, row + 1), lower);
    for (sum, other) in [(&mut *r0, r1), (&mut *g0, g1), (&mut *b0, b1)] {
        sensor::add_shifted(simd, other, 0, 1.0, sum);
    }
    let at = local / 2 * (width / 2)..(local / 2 + 1) * (width / 2);
    sensor::chroma(
        simd,
        &upper_row,
        [r0, g0, b0],
        [noise_row(2, row), noise_row(3, row)],
        &mut samples.u[at.clone()],
        &mut samples.v[at],
    );
}

/// Reads a row of light and the next one: with motion blur, or with the softness of the lens where the
/// picture rests.
fn blur_two_rows(
    view: &FrameView<'_>,
    light: &LightRows,
    blur: (f64, f64),
    row: usize,
    samples: &mut SampleBand,
) {
    let simd = view.settings.simd;
    let is_moving = libm::hypot(blur.0, blur.1) > MIN_BLUR_PX;
    for half in 0..2 {
        let from = (row + half) as i64;
        for channel in 0..3 {
            let out = &mut samples.rows[3 * half + channel];
            if !view.settings.effects.blur {
                light.read_row(from, channel, |values| out.copy_from_slice(values));
            } else if is_moving {
                let taps = (libm::ceil(libm::hypot(blur.0, blur.1)) as usize + 1).min(MAX_TAPS);
                out.fill(0.0);
                for tap in 0..taps {
                    let part = tap as f64 / (taps - 1).max(1) as f64 - 0.5;
                    let (du, dv) = (libm::rint(part * blur.0), libm::rint(part * blur.1));
                    light.read_row(from + dv as i64, channel, |values| {
                        sensor::add_shifted(simd, values, du as i32, 1.0 / taps as f32, out);
                    });
                }
            } else {
                let scratch = &mut samples.scratch;
                light.read_row(from - 1, channel, |up| {
                    light.read_row(from, channel, |here| {
                        light.read_row(from + 1, channel, |down| {
                            sensor::soften(simd, [up, here, down], LENS_SOFTNESS, scratch, out);
                        });
                    });
                });
            }
        }
    }
}
