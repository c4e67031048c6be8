//! One evaluation of filter and colour in a search window.

use crate::correlation::Peak;
use crate::crop::ColourContrast;
use crate::features::PatchPose;

/// The peak of the filter's response in one search window, and the colour at that peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observation {
    /// Pose of the search window.
    pub(super) pose: PatchPose,
    /// Position of the peak, pixels, within the picture.
    pub(super) centre: (f32, f32),
    pub(super) peak: Peak,
    /// Target probability in the target's ellipse at the peak, and around it.
    pub(super) contrast: ColourContrast,
}
