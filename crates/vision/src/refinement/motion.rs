//! What moved with the target and what with the background, by comparison with an earlier frame.
//!
//! An earlier frame's brightness is compared with the present one in two alignments: moved as the target
//! moved since, and moved as the background moved since. Where the first fits better, the picture shows the
//! target. The two alignments differ only if the target moved against the background; with a target at rest,
//! the comparison says nothing.

use crate::crop::{Crop, CropLuma};
use crate::sampling::{SampleRow, SamplingGrid, sample_bilinear};

/// Minimum age of a reference when the next one is taken, seconds: the frames that are compared are one to
/// two such intervals apart.
const REFERENCE_INTERVAL_S: f64 = 0.2;
/// Noise of the brightness, levels: a constant, and a share of the standard deviation within the window.
const NOISE: f32 = 2.0;
const NOISE_SHARE: f32 = 0.05;

/// An earlier frame's brightness around the target.
#[derive(Debug, Default)]
struct MotionReference {
    luma: CropLuma,
    /// Sum of the background's shifts since, pixels.
    shift: (f32, f32),
    /// Centre of the target's box then, pixels.
    centre: (f32, f32),
    /// Time of capture, seconds.
    at_s: f64,
    is_valid: bool,
}

/// Two references of different ages, of which the older is compared.
#[derive(Debug, Default)]
pub(crate) struct MotionReferences {
    old: MotionReference,
    young: MotionReference,
}

/// Buffers of a comparison.
#[derive(Debug, Clone, Default)]
pub(super) struct MotionBuffers {
    with_background: Vec<f32>,
    with_target: Vec<f32>,
    row: SampleRow,
}

impl MotionReferences {
    /// Adds the background's shift since the last frame, pixels. An unknown one invalidates both references.
    pub(crate) fn add_background_shift(&mut self, shift: Option<(f32, f32)>) {
        for reference in [&mut self.old, &mut self.young] {
            match shift {
                Some((u, v)) => reference.shift = (reference.shift.0 + u, reference.shift.1 + v),
                None => reference.is_valid = false,
            }
        }
    }

    /// Takes this frame as a reference if the last one is old enough. `centre` is that of the target's box,
    /// pixels.
    pub(crate) fn update(&mut self, crop: &Crop, centre: (f32, f32), at_s: f64) {
        let age = at_s - self.young.at_s;
        if self.young.is_valid && self.old.is_valid && (0.0..REFERENCE_INTERVAL_S).contains(&age) {
            return;
        }
        if self.young.is_valid {
            core::mem::swap(&mut self.old, &mut self.young);
        }
        let young = &mut self.young;
        crop.copy_luma(&mut young.luma);
        (young.shift, young.centre, young.at_s, young.is_valid) = ((0.0, 0.0), centre, at_s, true);
        if !self.old.is_valid {
            let Self { old, young } = self;
            old.luma.copy_from(&young.luma);
            (old.shift, old.centre, old.at_s, old.is_valid) = (young.shift, young.centre, young.at_s, true);
        }
    }

    /// Discards both.
    pub(crate) fn clear(&mut self) {
        self.old.is_valid = false;
        self.young.is_valid = false;
    }

    /// How far a target whose box is now at `centre` moved against the background since the reference,
    /// pixels; `None` without a reference.
    pub(crate) fn relative_motion(&self, centre: (f32, f32)) -> Option<(f32, f32)> {
        let old = &self.old;
        let moved = (centre.0 - old.centre.0 - old.shift.0, centre.1 - old.centre.1 - old.shift.1);
        old.is_valid.then_some(moved)
    }

    /// Compares the samples `luma` of `grid` with the reference: for each block of 2 x 2 samples 1 where the
    /// picture moved with the target, -1 where it moved with the background, 0 where nothing is known.
    /// `tracked` is the centre of the target's box, pixels, `deviation` the standard deviation of the
    /// samples.
    pub(super) fn compare(
        &self,
        grid: &SamplingGrid,
        tracked: (f32, f32),
        luma: &[f32],
        deviation: f32,
        buffers: &mut MotionBuffers,
        out: &mut [f32],
    ) {
        let reference = &self.old;
        if !reference.is_valid || reference.luma.decimation <= 0.0 {
            return;
        }
        let at = |centre: (f32, f32)| reference.luma.to_samples(&SamplingGrid { centre, ..*grid });
        let (u, v) = grid.centre;
        let by_background = at((u - reference.shift.0, v - reference.shift.1));
        let by_target = at((reference.centre.0 + u - tracked.0, reference.centre.1 + v - tracked.1));
        sample_bilinear(&reference.luma.map, by_background, &mut buffers.row, &mut buffers.with_background);
        sample_bilinear(&reference.luma.map, by_target, &mut buffers.row, &mut buffers.with_target);
        for map in [&mut buffers.with_background, &mut buffers.with_target] {
            for (value, luma) in map.iter_mut().zip(luma) {
                *value = (*value - luma).abs();
            }
        }
        let noise = NOISE + NOISE_SHARE * deviation;
        let (across, down) = (grid.width / 2, grid.height / 2);
        for row in 0..down {
            for column in 0..across {
                let is_covered =
                    |grid: &SamplingGrid| reference.luma.contains(grid.block_centre(column, row));
                if !is_covered(&by_background) || !is_covered(&by_target) {
                    continue;
                }
                let mean = |map: &[f32]| {
                    let first = 2 * row * grid.width + 2 * column;
                    let below = first + grid.width;
                    0.25 * (map[first] + map[first + 1] + map[below] + map[below + 1])
                };
                let (background, target) = (mean(&buffers.with_background), mean(&buffers.with_target));
                out[row * across + column] = (background - target) / (background + target + 2.0 * noise);
            }
        }
    }
}
