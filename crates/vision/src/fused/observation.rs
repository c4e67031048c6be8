//! The result of one evaluation of filter, colour and network at a place.

use crate::features::PatchPose;
use crate::peak::Peak;
use crate::probability_view::ColourContrast;
use crate::refinement::RefinedBox;

/// The peak of the filter's response in one search window, and the colour at that peak. *Relative* means
/// divided by the target's usual value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observation {
    /// Pose of the search window.
    pub(super) pose: PatchPose,
    /// Position of the peak, pixels, within the picture.
    pub(super) centre: (f32, f32),
    pub(super) peak: Peak,
    /// Target probability in the target's ellipse at the peak, and around it.
    pub(super) contrast: ColourContrast,
    /// Relative height of the response.
    pub(super) relative_height: f32,
    /// Relative contrast of the colour, 0 to 1; `None` where the colour is not used.
    pub(super) relative_contrast: Option<f32>,
    /// Evidence for the target, in standard deviations of the response's sidelobes.
    pub(super) evidence: f32,
}

/// A place where the target may be, with the network's box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub(super) observation: Observation,
    pub(super) refined: RefinedBox,
}

impl Observation {
    /// Whether the colour is not used, or has at least this share of its usual contrast.
    pub(super) fn has_its_colour(&self, min_share: f32) -> bool {
        self.relative_contrast.is_none_or(|share| share >= min_share)
    }
}
