//! The window that the refinement network reads: channels of cells in an upright window around the target's
//! box, and measurements of the observation.

use super::memory::WindowMemory;
use super::motion::{MotionBuffers, MotionReferences};
use crate::crop::Crop;
use crate::sampling::SamplingGrid;

/// Cells along a side of the window.
pub const WINDOW_SIDE_CELLS: usize = 32;
/// Number of channels.
pub const WINDOW_CHANNELS: usize = 11;
/// Number of measurements.
pub const MEASUREMENTS: usize = 12;

/// Cells of a channel.
const CELLS: usize = WINDOW_SIDE_CELLS * WINDOW_SIDE_CELLS;
/// Samples along a side: two for each cell.
const SAMPLES: usize = 2 * WINDOW_SIDE_CELLS;
/// Sides of the window, in sides of the box.
const WINDOW_SIDES: f32 = 2.5;
/// Minimum side of the box for this, as a share of its longer side.
const MIN_SIDES_RATIO: f32 = 0.25;
/// Offsets of the divisors of brightness (levels) and gradient (levels per sample).
const BRIGHTNESS_OFFSET: f32 = 8.0;
const GRADIENT_OFFSET: f32 = 3.0;
/// Chroma that gives 1, levels from the window's mean.
const CHROMA_UNIT: f32 = 24.0;
/// Bounds of the channels.
const MAX_BRIGHTNESS: f32 = 1.5;
const MAX_GRADIENT: f32 = 2.0;
const MAX_CHROMA: f32 = 2.0;

/// The channels in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    /// Brightness less the window's mean, over twice its standard deviation.
    Brightness,
    /// Absolute gradient, over twice the window's mean.
    Gradient,
    /// Target probability of the colour, 0 to 1.
    TargetProbability,
    /// 1 where the picture moved with the target, -1 where it moved with the background.
    Motion,
    /// Share of the cell in the box.
    Box,
    /// Brightness at the selection.
    SelectedBrightness,
    /// Running mean of the brightness.
    UsualBrightness,
    /// 1 outside the picture, where all other channels but the box and the memory are 0.
    Outside,
    /// Chroma less the window's mean.
    ChromaU,
    /// The same of V.
    ChromaV,
    /// Target probability at the selection.
    SelectedProbability,
}

/// Cells and measurements of one observation.
#[derive(Debug, Clone)]
pub struct RefinementWindow {
    /// Channel by channel, row by row.
    pub cells: Vec<f32>,
    /// Measurements of the observation.
    pub measurements: [f32; MEASUREMENTS],
    /// Centre of the window and of the box, pixels.
    pub centre: (f32, f32),
    /// Width and height of the window, pixels.
    pub sides: (f32, f32),
    /// Width and height of the box, pixels.
    pub box_size: (f32, f32),
    luma: Vec<f32>,
    probability: Vec<f32>,
    chroma: [Vec<f32>; 2],
    motion: MotionBuffers,
}

/// What a window is measured from, beside the picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WindowContext<'a> {
    /// Centre of the target's box by the tracker, pixels: it may differ from the window's.
    pub(crate) tracked: (f32, f32),
    /// Width and height of the picture, pixels.
    pub(crate) picture: (f32, f32),
    pub(crate) memory: &'a WindowMemory,
    pub(crate) references: &'a MotionReferences,
}

/// Measurements of an observation, each of about unit size.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Measurements {
    pub(crate) peak_to_sidelobe_ratio: f32,
    /// Height of the response, relative to its usual value.
    pub(crate) relative_height: f32,
    /// Contrast of the colour relative to its usual value; `None` where the colour is not used.
    pub(crate) relative_contrast: Option<f32>,
    pub(crate) usual_contrast: f32,
    /// Target probability in the target's ellipse and in the ring around it, 0 to 1.
    pub(crate) inside: f32,
    pub(crate) ring: f32,
    /// Size over that at the selection.
    pub(crate) scale: f32,
    /// Distance from the prediction, sizes.
    pub(crate) distance_sizes: f32,
    /// Motion against the background since the motion reference, sizes; `None` without a reference.
    pub(crate) relative_motion_sizes: Option<f32>,
    /// Size of the box, pixels.
    pub(crate) size_px: f32,
    /// Whether there is a reference silhouette.
    pub(crate) has_silhouette: bool,
    pub(crate) evidence: f32,
}

impl Measurements {
    /// Scaled to about unit size.
    fn scaled(&self) -> [f32; MEASUREMENTS] {
        /// Largest distances, sizes.
        const FAR: f32 = 4.0;
        /// In place of what is not known.
        const UNKNOWN: f32 = -0.5;
        [
            0.05 * self.peak_to_sidelobe_ratio,
            self.relative_height,
            self.relative_contrast.unwrap_or(UNKNOWN),
            self.usual_contrast,
            self.inside,
            self.ring,
            libm::logf(self.scale),
            self.distance_sizes.min(FAR),
            self.relative_motion_sizes.map_or(UNKNOWN, |sizes| sizes.min(FAR)),
            libm::logf(self.size_px / 32.0),
            f32::from(u8::from(self.has_silhouette)),
            0.05 * self.evidence,
        ]
        .map(|value| if value.is_finite() { value.clamp(-5.0, 5.0) } else { 0.0 })
    }
}

impl Default for RefinementWindow {
    fn default() -> Self {
        Self {
            cells: vec![0.0; WINDOW_CHANNELS * CELLS],
            measurements: [0.0; MEASUREMENTS],
            centre: (0.0, 0.0),
            sides: (1.0, 1.0),
            box_size: (1.0, 1.0),
            luma: Vec::new(),
            probability: Vec::new(),
            chroma: [Vec::new(), Vec::new()],
            motion: MotionBuffers::default(),
        }
    }
}

impl RefinementWindow {
    /// Left, top, right and bottom edge of the box, pixels.
    pub(crate) fn box_edges(&self) -> [f32; 4] {
        let ((u, v), (w, h)) = (self.centre, self.box_size);
        [u - 0.5 * w, v - 0.5 * h, u + 0.5 * w, v + 0.5 * h]
    }

    /// Copies cells and measurements of another window, with its place.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.cells.copy_from_slice(&other.cells);
        self.measurements = other.measurements;
        (self.centre, self.sides, self.box_size) = (other.centre, other.sides, other.box_size);
    }

    /// The cells of a channel.
    fn channel(&self, channel: Channel) -> &[f32] {
        &self.cells[channel as usize * CELLS..][..CELLS]
    }

    fn channel_mut(&mut self, channel: Channel) -> &mut [f32] {
        &mut self.cells[channel as usize * CELLS..][..CELLS]
    }

    /// Makes this window that of the selection.
    pub(crate) fn remember_selection(&self, memory: &mut WindowMemory) {
        memory.set(self.channel(Channel::Brightness), self.channel(Channel::TargetProbability));
    }

    /// Adapts the memory to this window.
    pub(crate) fn remember_usual(&self, memory: &mut WindowMemory) {
        memory.adapt(self.channel(Channel::Brightness));
    }

    /// Keeps the measurements of the observation.
    pub(crate) fn set_measurements(&mut self, measurements: &Measurements) {
        self.measurements = measurements.scaled();
    }

    /// Measures the window around a box with this centre and size (width, height), pixels.
    pub(crate) fn measure(
        &mut self,
        crop: &mut Crop,
        centre: (f32, f32),
        box_size: (f32, f32),
        context: WindowContext<'_>,
    ) {
        let longer = box_size.0.max(box_size.1);
        let side = |side: f32| WINDOW_SIDES * side.max(MIN_SIDES_RATIO * longer);
        (self.centre, self.box_size, self.sides) = (centre, box_size, (side(box_size.0), side(box_size.1)));
        let grid = SamplingGrid {
            centre,
            step: self.sides.0 / SAMPLES as f32,
            stretch: self.sides.1 / self.sides.0,
            turn: (1.0, 0.0),
            width: SAMPLES,
            height: SAMPLES,
        };
        let coarse = SamplingGrid {
            step: 2.0 * grid.step,
            width: WINDOW_SIDE_CELLS,
            height: WINDOW_SIDE_CELLS,
            ..grid
        };
        crop.sample_luma(&grid, &mut self.luma);
        crop.sample_probability(&coarse, &mut self.probability);
        crop.sample_chroma(&coarse, &mut self.chroma);
        self.cells.fill(0.0);
        let covered = self.mark_outside(&coarse, context.picture);
        let deviation = self.fill_appearance(covered);
        self.fill_box(&coarse);
        let memory = context.memory;
        for (channel, cells) in [
            (Channel::SelectedBrightness, &memory.selected),
            (Channel::UsualBrightness, &memory.usual),
            (Channel::SelectedProbability, &memory.selected_probability),
        ] {
            if cells.len() == CELLS {
                self.channel_mut(channel).copy_from_slice(cells);
            }
        }
        let Self { cells, luma, motion, .. } = self;
        let (before, after) = cells.split_at_mut(Channel::Outside as usize * CELLS);
        let out = &mut before[Channel::Motion as usize * CELLS..][..CELLS];
        context.references.compare(&grid, context.tracked, luma, deviation, motion, out);
        for (value, outside) in out.iter_mut().zip(after) {
            *value *= 1.0 - *outside;
        }
    }

    /// Marks the cells outside the picture; the number of the others, at least 1.
    fn mark_outside(&mut self, grid: &SamplingGrid, picture: (f32, f32)) -> f32 {
        let mut covered = 0.0;
        let cells = self.channel_mut(Channel::Outside);
        for (index, outside) in cells.iter_mut().enumerate() {
            let (u, v) = grid.sample_centre(index % WINDOW_SIDE_CELLS, index / WINDOW_SIDE_CELLS);
            let is_inside = u >= 0.0 && v >= 0.0 && u <= picture.0 && v <= picture.1;
            *outside = f32::from(u8::from(!is_inside));
            covered += 1.0 - *outside;
        }
        f32::max(covered, 1.0)
    }

    /// Fills the channels of brightness, gradient, target probability and chroma; the standard deviation of
    /// the brightness, levels. `covered` is the number of cells in the picture.
    fn fill_appearance(&mut self, covered: f32) -> f32 {
        let cells = &mut self.cells;
        let (mut sum, mut squares, mut gradients) = (0.0_f32, 0.0_f32, 0.0_f32);
        let mut chroma_sums = [0.0_f32; 2];
        for index in 0..CELLS {
            let inside = 1.0 - cells[Channel::Outside as usize * CELLS + index];
            let first = 2 * (index / WINDOW_SIDE_CELLS) * SAMPLES + 2 * (index % WINDOW_SIDE_CELLS);
            let (a, b) = (self.luma[first], self.luma[first + 1]);
            let (c, d) = (self.luma[first + SAMPLES], self.luma[first + SAMPLES + 1]);
            let mean = 0.25 * (a + b + c + d);
            let (right, down) = (b + d - a - c, c + d - a - b);
            let gradient = inside * 0.5 * (right * right + down * down).sqrt();
            cells[Channel::Brightness as usize * CELLS + index] = mean;
            cells[Channel::Gradient as usize * CELLS + index] = gradient;
            cells[Channel::TargetProbability as usize * CELLS + index] =
                inside * self.probability[index] * (1.0 / 255.0);
            sum += inside * mean;
            squares += inside * mean * mean;
            gradients += gradient;
            for (sum, chroma) in chroma_sums.iter_mut().zip(&self.chroma) {
                *sum += inside * chroma[index];
            }
        }
        let mean = sum / covered;
        let deviation = (squares / covered - mean * mean).max(0.0).sqrt();
        let brightness_gain = 0.5 / (deviation + BRIGHTNESS_OFFSET);
        let gradient_gain = 0.5 / (gradients / covered + GRADIENT_OFFSET);
        for index in 0..CELLS {
            let inside = 1.0 - cells[Channel::Outside as usize * CELLS + index];
            let brightness = &mut cells[Channel::Brightness as usize * CELLS + index];
            *brightness =
                inside * ((*brightness - mean) * brightness_gain).clamp(-MAX_BRIGHTNESS, MAX_BRIGHTNESS);
            let gradient = &mut cells[Channel::Gradient as usize * CELLS + index];
            *gradient = (*gradient * gradient_gain).min(MAX_GRADIENT);
            let channels = [Channel::ChromaU, Channel::ChromaV];
            for (channel, (chroma, sum)) in channels.into_iter().zip(self.chroma.iter().zip(chroma_sums)) {
                let from_mean = (chroma[index] - sum / covered) * (1.0 / CHROMA_UNIT);
                cells[channel as usize * CELLS + index] = inside * from_mean.clamp(-MAX_CHROMA, MAX_CHROMA);
            }
        }
        deviation
    }

    /// Fills the channel of the box.
    fn fill_box(&mut self, grid: &SamplingGrid) {
        let (width, height) = self.box_size;
        let share = |index: usize, cell: f32, side: f32| {
            let from = (index as f32 - (WINDOW_SIDE_CELLS / 2) as f32) * cell;
            ((from + cell).min(0.5 * side) - from.max(-0.5 * side)).max(0.0) / cell
        };
        let across: [f32; WINDOW_SIDE_CELLS] = core::array::from_fn(|column| share(column, grid.step, width));
        let cells = self.channel_mut(Channel::Box);
        for (row, cells) in cells.chunks_exact_mut(WINDOW_SIDE_CELLS).enumerate() {
            let down = share(row, grid.step * grid.stretch, height);
            for (value, across) in cells.iter_mut().zip(across) {
                *value = across * down;
            }
        }
    }
}
