//! Feature channels of a patch, on which the correlation filter works.
//!
//! Nine gradient directions, the brightness, and the target probability of the colour, in cells of [`CELL`] x
//! [`CELL`] samples. Cells outside the picture are blank.

use crate::correlation::CorrelationFilter;
use crate::crop::Crop;
use crate::fourier::{AREA, Fourier, Map, SIDE, Spectrum, hann_window};
use crate::gradients::{CELL, DIRECTIONS, GradientHistograms, MARGIN, unit_directions};
use crate::sampling::SamplingGrid;
use crate::simd::simd_kernel;
use crate::vector::{Rotation, Vector, scaled, sum};

/// Number of channels, an even number; the last one is empty.
pub(crate) const CHANNELS: usize = DIRECTIONS + 3;
/// Channel of the brightness.
const LUMA: usize = DIRECTIONS;
/// Channel of the target probability.
const PROBABILITY: usize = DIRECTIONS + 1;

/// Position, scale and rotation of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PatchPose {
    /// Centre, pixels.
    pub(crate) centre: (f32, f32),
    /// Pixels per sample.
    pub(crate) step: f32,
    /// Rotation, radians, clockwise as seen.
    pub(crate) angle: f32,
}

impl PatchPose {
    pub(crate) fn sampling_grid(&self, width: usize, height: usize) -> SamplingGrid {
        SamplingGrid {
            centre: self.centre,
            step: self.step,
            stretch: 1.0,
            turn: (libm::cosf(self.angle), libm::sinf(self.angle)),
            width,
            height,
        }
    }

    /// Side of a whole patch of [`SIDE`] cells, pixels.
    pub(crate) fn side_px(&self) -> f32 {
        self.step * (SIDE * CELL) as f32
    }

    /// Converts a point given in samples right and down of the centre to pixels.
    pub(crate) fn to_picture(self, right: f32, down: f32) -> Vector {
        sum(self.centre, scaled(Rotation::by(self.angle).apply((right, down)), self.step))
    }

    /// Converts a point given in cells right and down of the centre to pixels.
    pub(crate) fn cell_to_picture(self, right: f32, down: f32) -> Vector {
        self.to_picture(right * CELL as f32, down * CELL as f32)
    }
}

#[derive(Debug)]
pub(crate) struct FeatureExtractor {
    luma: Vec<f32>,
    probability: Vec<f32>,
    gradients: GradientHistograms,
    directions: ([(f32, f32); DIRECTIONS], f32),
    window: Box<Map>,
    /// Unnormalised values, channel by channel.
    raw: Vec<f32>,
    maps: Vec<Box<Map>>,
    /// Spectra of the last whole patch, one per channel.
    pub(crate) spectra: Vec<Spectrum>,
    pub(crate) fourier: Fourier,
    luma_gain: f32,
    colour_gain: f32,
    /// Offset and gain of the brightness and of the target probability, from the last whole patch.
    normalisation: [(f32, f32); 2],
}

impl FeatureExtractor {
    pub(crate) fn new(luma_gain: f32, colour_gain: f32) -> Self {
        Self {
            luma: Vec::new(),
            probability: Vec::new(),
            gradients: GradientHistograms::default(),
            directions: unit_directions(),
            window: hann_window(),
            raw: Vec::new(),
            maps: vec![Box::new([0.0; AREA]); CHANNELS],
            spectra: vec![Spectrum::default(); CHANNELS],
            fourier: Fourier::new(),
            luma_gain,
            colour_gain,
            normalisation: [(0.0, 0.0); 2],
        }
    }

    /// Fills `raw` with `width * height` cells around the pose.
    fn fill_cells(&mut self, crop: &mut Crop, pose: &PatchPose, width: usize, height: usize) {
        let grid = pose.sampling_grid(width * CELL + 2 * MARGIN, height * CELL + 2 * MARGIN);
        let stride = grid.width;
        crop.sample_luma(&grid, &mut self.luma);
        self.gradients.compute(&self.luma, width, height, &self.directions.0, self.directions.1);
        let half = SamplingGrid {
            step: 2.0 * grid.step,
            width: width * CELL / 2,
            height: height * CELL / 2,
            ..grid
        };
        crop.sample_probability(&half, &mut self.probability);
        let area = width * height;
        self.raw.clear();
        self.raw.extend_from_slice(self.gradients.cells());
        self.raw.resize(CHANNELS * area, 0.0);
        let (brightness, rest) = self.raw[LUMA * area..].split_at_mut(area);
        let size = (width, height);
        cell_means(&self.luma[MARGIN * stride + MARGIN..], stride, size, brightness);
        cell_probabilities(&self.probability, size, &mut rest[..area]);
    }

    /// Computes the spectra of the whole patch at a pose. `bounds` is the picture's width and height, pixels.
    pub(crate) fn extract(&mut self, crop: &mut Crop, pose: &PatchPose, bounds: (f32, f32)) {
        self.fill_cells(crop, pose, SIDE, SIDE);
        let luma = &self.raw[LUMA * AREA..(LUMA + 1) * AREA];
        let mean_luma = luma.iter().sum::<f32>() / AREA as f32;
        let mean_probability =
            self.raw[PROBABILITY * AREA..(PROBABILITY + 1) * AREA].iter().sum::<f32>() / AREA as f32;
        let variance = luma.iter().map(|v| (v - mean_luma) * (v - mean_luma)).sum::<f32>() / AREA as f32;
        self.normalisation = [
            (mean_luma, 0.3 * self.luma_gain / (variance.sqrt() + 8.0)),
            (mean_probability, self.colour_gain),
        ];
        self.blank_outside(pose, SIDE, SIDE, bounds);
        for (channel, (map, raw)) in self.maps.iter_mut().zip(self.raw.chunks_exact(AREA)).enumerate() {
            let (offset, gain) = normalisation(&self.normalisation, channel);
            for ((value, window), raw) in map.iter_mut().zip(self.window.iter()).zip(raw) {
                *value = (raw - offset) * gain * window;
            }
        }
        for pair in 0..CHANNELS / 2 {
            let (first, second) = self.spectra.split_at_mut(2 * pair + 1);
            let maps = (&*self.maps[2 * pair], &*self.maps[2 * pair + 1]);
            self.fourier.forward_pair(maps, (&mut first[2 * pair], &mut second[0]));
        }
    }

    /// Blanks the cells outside the picture: gives them the value of the offset.
    fn blank_outside(&mut self, pose: &PatchPose, width: usize, height: usize, bounds: (f32, f32)) {
        let half = (0.5 * (width * CELL) as f32, 0.5 * (height * CELL) as f32);
        let inside = |p: (f32, f32)| p.0 >= 0.0 && p.1 >= 0.0 && p.0 <= bounds.0 && p.1 <= bounds.1;
        let corners = [(-half.0, -half.1), (half.0, -half.1), (-half.0, half.1), (half.0, half.1)];
        if corners.iter().all(|c| inside(pose.to_picture(c.0, c.1))) {
            return;
        }
        let area = width * height;
        for row in 0..height {
            for column in 0..width {
                let (right, down) =
                    ((column as f32 + 0.5) * CELL as f32 - half.0, (row as f32 + 0.5) * CELL as f32 - half.1);
                if !inside(pose.to_picture(right, down)) {
                    for channel in 0..CHANNELS {
                        self.raw[channel * area + row * width + column] =
                            normalisation(&self.normalisation, channel).0;
                    }
                }
            }
        }
    }

    /// Response of a filter to the patch at a pose, without a shift: the value that [`Self::extract`] and an
    /// inverse transform would give there, computed for that shift only. `half_size_cells` is the number of
    /// cells right and down of the centre that are summed.
    pub(crate) fn response_at(
        &mut self,
        crop: &mut Crop,
        pose: &PatchPose,
        filter: &CorrelationFilter,
        half_size_cells: (usize, usize),
        bounds: (f32, f32),
    ) -> f32 {
        let kernel = filter.kernel();
        let (nw, nh) = (half_size_cells.0.clamp(1, SIDE / 2), half_size_cells.1.clamp(1, SIDE / 2));
        let (width, height) = (2 * nw, 2 * nh);
        self.fill_cells(crop, pose, width, height);
        self.blank_outside(pose, width, height, bounds);
        let mut sums = [0.0_f32; CHANNELS];
        let area = width * height;
        for (channel, total) in sums.iter_mut().enumerate() {
            let (offset, gain) = normalisation(&self.normalisation, channel);
            for row in 0..height {
                let start = (SIDE / 2 - nh + row) * SIDE + SIDE / 2 - nw;
                let raw = &self.raw[channel * area + row * width..][..width];
                let mut sum = 0.0;
                for ((x, h), w) in raw
                    .iter()
                    .zip(&kernel[channel * AREA + start..][..width])
                    .zip(&self.window[start..start + width])
                {
                    sum += (x - offset) * w * h;
                }
                *total += sum * gain;
            }
        }
        sums.iter().sum()
    }
}

simd_kernel! {
/// Mean of each of `size` (width, height) cells of [`CELL`] x [`CELL`] samples.
fn cell_means(samples: &[f32], stride: usize, size: (usize, usize), out: &mut [f32]) {
    for (row, out) in out.chunks_exact_mut(size.0).enumerate() {
        let mut lines = samples[row * CELL * stride..].chunks(stride);
        out.fill(0.0);
        for line in lines.by_ref().take(CELL) {
            for (sum, cell) in out.iter_mut().zip(line.as_chunks::<CELL>().0) {
                *sum += cell[0] + cell[1] + cell[2] + cell[3];
            }
        }
        for sum in out {
            *sum *= 1.0 / 16.0;
        }
    }
}
}

simd_kernel! {
/// Mean of each of `size` (width, height) cells of 2 x 2 target probabilities, from 0 to 255, as a share.
fn cell_probabilities(samples: &[f32], size: (usize, usize), out: &mut [f32]) {
    let width = 2 * size.0;
    for (lines, out) in samples.chunks_exact(2 * width).zip(out.chunks_exact_mut(size.0)) {
        let (upper, lower) = lines.split_at(width);
        for ((out, upper), lower) in out.iter_mut().zip(upper.as_chunks::<2>().0).zip(lower.as_chunks::<2>().0) {
            *out = (upper[0] + upper[1] + lower[0] + lower[1]) * (0.25 / 255.0);
        }
    }
}
}

fn normalisation(normalisation: &[(f32, f32); 2], channel: usize) -> (f32, f32) {
    match channel.checked_sub(LUMA) {
        None => (0.0, 1.0),
        Some(k) => normalisation.get(k).copied().unwrap_or((0.0, 0.0)),
    }
}
