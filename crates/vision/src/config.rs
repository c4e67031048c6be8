//! Settings of CamShift.

use thiserror::Error;

use crate::hue::{Floors, HUE_CODES};
use crate::mean_shift::TerminationCriteria;

/// Settings of [`CamShift`](crate::CamShift).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CamShiftConfig {
    /// Minimum saturation (of 255, hexcone) of a pixel whose hue counts; 0 to 255, default 60. Below it the
    /// hue is mostly noise. The laboratory's operators chose 52 to 130, depending on the venue.
    pub saturation_floor: u8,
    /// Minimum value (of 255: the maximum of red, green and blue) of a pixel whose hue counts; 0 to 255,
    /// default 32. The hue of darker pixels is mostly noise. The laboratory's operators chose 10 to 100.
    pub value_floor: u8,
    /// Number of equal bins of the hue circle, the first starting at 0 degrees (red); 2 to 180, default 16 as
    /// in the paper. A bin of 22.5 degrees covers light and shade on one paint. Red lies on both sides of 0,
    /// and so in the first and in the last bin.
    pub bins: usize,
    /// Maximum number of mean-shift steps per frame; 1 to 100, default 10 as in the paper. Bounds the work.
    pub max_iterations: u32,
    /// Mean shift ends after a step shorter than this, pixels; above 0, at most 100, default 1 as in the
    /// paper: the window moves by whole pixels, so it is then at rest.
    pub epsilon_px: f64,
    /// Margin computed around the search window when the window reaches the border of the computed part of
    /// the back projection, pixels; 0 to 1000, default 12. It changes the cost, not the result: a larger
    /// margin gives fewer but larger pieces of work. 12 covers the margin of the moments (10) and the step of
    /// a slow target.
    pub search_margin_px: usize,
}

impl Default for CamShiftConfig {
    fn default() -> Self {
        Self {
            saturation_floor: 60,
            value_floor: 32,
            bins: 16,
            max_iterations: 10,
            epsilon_px: 1.0,
            search_margin_px: 12,
        }
    }
}

impl CamShiftConfig {
    /// Returns the same settings if all are in range.
    ///
    /// # Errors
    /// Names the first setting that is out of range, its value and the range.
    pub fn validated(self) -> Result<Self, CamShiftConfigError> {
        if !(2..=usize::from(HUE_CODES)).contains(&self.bins) {
            return Err(CamShiftConfigError::Bins(self.bins));
        }
        if !(1..=100).contains(&self.max_iterations) {
            return Err(CamShiftConfigError::MaxIterations(self.max_iterations));
        }
        if !(self.epsilon_px > 0.0 && self.epsilon_px <= 100.0) {
            return Err(CamShiftConfigError::Epsilon(self.epsilon_px));
        }
        if self.search_margin_px > 1000 {
            return Err(CamShiftConfigError::SearchMargin(self.search_margin_px));
        }
        Ok(self)
    }

    pub(crate) const fn floors(&self) -> Floors {
        Floors { saturation: self.saturation_floor, value: self.value_floor }
    }

    pub(crate) const fn termination_criteria(&self) -> TerminationCriteria {
        TerminationCriteria { max_iterations: self.max_iterations, epsilon_px: self.epsilon_px }
    }
}

/// A setting that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum CamShiftConfigError {
    /// The number of bins.
    #[error("bins = {0}: use 2 to 180 (16 is the paper's)")]
    Bins(usize),
    /// The number of mean-shift steps.
    #[error("max_iterations = {0}: use 1 to 100 (10 is the paper's)")]
    MaxIterations(u32),
    /// The length of the last step.
    #[error("epsilon_px = {0}: use a number above 0 and at most 100 (1 is the paper's)")]
    Epsilon(f64),
    /// The margin of the search.
    #[error("search_margin_px = {0}: use 0 to 1000 (12 by default)")]
    SearchMargin(usize),
}
