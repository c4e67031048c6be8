//! What is known of the target's paint: its chroma, its silhouette at the selection, and where it was last seen.

use super::reference_silhouette::ReferenceSilhouette;
use crate::paint::Paint;

/// The paint of a target, and its silhouette at the selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TargetPaint {
    pub(super) paint: Paint,
    pub(super) reference: ReferenceSilhouette,
}

/// The blob as it was last measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeenBlob {
    /// From the centre of the target's box to the centroid, pixels.
    pub(super) from_centre: (f32, f32),
    /// Half axes, pixels.
    pub(super) half: (f32, f32),
    /// Radians clockwise from image right.
    pub(super) axis: f32,
    /// Square pixels.
    pub(super) area: f32,
    /// Time since the measurement, seconds.
    pub(super) age_s: f32,
}
