//! What the tracker has learned of the target's appearance.

use crate::colour_model::ColourModel;
use crate::correlation::CorrelationFilter;
use crate::fourier::{AREA, Map, Spectrum};
use crate::layout::ColourLayout;
use crate::probability_view::ColourContrast;

/// Minimum usual contrast of a target whose colour is used, 0 to 1. Not measured individually.
pub(super) const MIN_CONTRAST: f32 = 0.15;
/// Lower bound of the usual height, as a divisor.
const MIN_USUAL_HEIGHT: f32 = 0.05;

/// Height of a response relative to the usual one.
pub(super) fn relative_height(height: f32, usual: f32) -> f32 {
    height / usual.max(MIN_USUAL_HEIGHT)
}

/// Filter and colour models of the target.
#[derive(Debug, Clone)]
pub(super) struct Appearance {
    pub(super) filter: CorrelationFilter,
    /// Spectrum of the response that the filter is trained for.
    pub(super) desired_response: Spectrum,
    /// Support of the filter: 1 near the target, 0 elsewhere.
    pub(super) mask: Box<Map>,
    /// Half the size of the mask, right and down, cells.
    pub(super) mask_half_cells: (usize, usize),
    pub(super) colours: ColourModel,
    pub(super) layout: ColourLayout,
    pub(super) usual: UsualValues,
    /// Number of frames learned from.
    pub(super) frames_learned: u32,
}

/// Running means of measurements at the target. Observations are compared with these means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UsualValues {
    /// Target probability inside the target less that in the ring around it.
    pub(super) contrast: f32,
    /// Height of the filter's response.
    pub(super) peak_height: f32,
    /// Similarity of the target's colours to the learned ones, 0 to 1.
    pub(super) similarity: f32,
    /// Similarity of the layout of the colours to the learned one, 0 to 1.
    pub(super) layout_similarity: f32,
}

impl Appearance {
    /// An appearance of which only the colours are known, with a first estimate of the usual values.
    pub(super) fn new(colours: ColourModel, usual: UsualValues) -> Self {
        Self {
            filter: CorrelationFilter::default(),
            desired_response: Spectrum::default(),
            mask: Box::new([0.0; AREA]),
            mask_half_cells: (0, 0),
            colours,
            layout: ColourLayout::default(),
            usual,
            frames_learned: 0,
        }
    }
}

impl UsualValues {
    /// Contrast of the colour relative to its usual value, 0 to 1; `None` where the colour is not used.
    pub(super) fn relative_contrast(&self, contrast: ColourContrast) -> Option<f32> {
        self.is_colour_used().then(|| (contrast.difference() / self.contrast).clamp(0.0, 1.0))
    }

    /// Height of a response relative to its usual value.
    pub(super) fn relative_height(&self, height: f32) -> f32 {
        relative_height(height, self.peak_height)
    }

    /// Whether the colour is used.
    pub(super) fn is_colour_used(&self) -> bool {
        self.contrast > MIN_CONTRAST
    }
}
