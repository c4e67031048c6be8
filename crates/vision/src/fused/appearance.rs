//! What the tracker has learned of the target's appearance.

use crate::colour_model::ColourModel;
use crate::correlation::CorrelationFilter;
use crate::fourier::{AREA, Map, Spectrum};
use crate::layout::ColourLayout;

/// Initial estimate of the usual height of the response's peak.
const INITIAL_PEAK_HEIGHT: f32 = 0.7;
/// Initial estimate of the usual similarity of the target's colours and of their layout.
const INITIAL_SIMILARITY: f32 = 0.95;

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

/// Running means of what is measured at the target: the scale on which an observation is judged.
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
    /// An appearance of which only the colours are known.
    pub(super) fn new(colours: ColourModel) -> Self {
        Self {
            filter: CorrelationFilter::default(),
            desired_response: Spectrum::default(),
            mask: Box::new([0.0; AREA]),
            mask_half_cells: (0, 0),
            colours,
            layout: ColourLayout::default(),
            usual: UsualValues {
                contrast: 0.0,
                peak_height: INITIAL_PEAK_HEIGHT,
                similarity: INITIAL_SIMILARITY,
                layout_similarity: INITIAL_SIMILARITY,
            },
            frames_learned: 0,
        }
    }
}
