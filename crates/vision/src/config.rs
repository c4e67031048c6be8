//! The settings of CamShift.

use thiserror::Error;

use crate::hue::{Floors, HUES};
use crate::mean_shift::Criteria;

/// Settings of [`CamShift`](crate::CamShift).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CamShiftConfig {
    /// Least saturation (of 255, hexcone) at which a pixel's hue counts; 0 to 255, default 60. Below it the hue is
    /// mostly noise: the laboratory's operators chose 52 to 130 by venue.
    pub saturation_floor: u8,
    /// Least value (of 255: the largest of red, green and blue) at which a pixel's hue counts; 0 to 255, default
    /// 32. Of darker pixels the hue is mostly noise: the laboratory's operators chose 10 to 100.
    pub value_floor: u8,
    /// Equal parts into which the circle of hues is cut, the first from 0 degrees (red) on; 2 to 180, default 16,
    /// as in the paper: 22.5 degrees each, wide enough for light and shade on one paint. Red lies on both sides of
    /// 0 and so in the first and in the last.
    pub bins: usize,
    /// Most steps of the mean shift in one frame; 1 to 100, default 10, as in the paper. It bounds the work.
    pub max_iterations: u32,
    /// A step of the mean shift shorter than this ends it, pixels; above 0, at most 100, default 1, as in the
    /// paper: the window moves by whole pixels, so it has come to rest.
    pub epsilon_px: f64,
    /// How far beyond what is needed the back projection is worked out when the search window runs into the border
    /// of what is known, pixels; 0 to 1000, default 12. It changes the cost and never the answer: more of it means
    /// fewer but larger pieces of work. 12 covers the margin of the moments (10) and a slow target's step.
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
    /// The same settings, if every one lies in its range.
    ///
    /// # Errors
    /// Names the first setting that does not, its value and the range.
    pub fn validated(self) -> Result<Self, ConfigError> {
        if !(2..=usize::from(HUES)).contains(&self.bins) {
            return Err(ConfigError::Bins(self.bins));
        }
        if !(1..=100).contains(&self.max_iterations) {
            return Err(ConfigError::MaxIterations(self.max_iterations));
        }
        if !(self.epsilon_px > 0.0 && self.epsilon_px <= 100.0) {
            return Err(ConfigError::Epsilon(self.epsilon_px));
        }
        if self.search_margin_px > 1000 {
            return Err(ConfigError::SearchMargin(self.search_margin_px));
        }
        Ok(self)
    }

    pub(crate) const fn floors(&self) -> Floors {
        Floors { saturation: self.saturation_floor, value: self.value_floor }
    }

    pub(crate) const fn criteria(&self) -> Criteria {
        Criteria { max_iterations: self.max_iterations, epsilon_px: self.epsilon_px }
    }
}

/// A setting outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ConfigError {
    /// The number of bins.
    #[error("bins = {0}: use 2 to 180 (16 is the paper's)")]
    Bins(usize),
    /// The number of steps.
    #[error("max_iterations = {0}: use 1 to 100 (10 is the paper's)")]
    MaxIterations(u32),
    /// The length of the last step.
    #[error("epsilon_px = {0}: use a number above 0 and at most 100 (1 is the paper's)")]
    Epsilon(f64),
    /// The margin of the search.
    #[error("search_margin_px = {0}: use 0 to 1000 (12 by default)")]
    SearchMargin(usize),
}
