//! The silhouette at the selection, to which later silhouettes are compared.

use crate::silhouette::Silhouette;

/// What the colour showed of the target's shape at the selection, and how the operator's box lay around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ReferenceSilhouette {
    /// From the centroid of the colour to the centre of the box, pixels along the axis and across it (clockwise).
    pub(super) box_from_centroid: (f32, f32),
    /// From the midpoint between the ends of the colour to the centre of the box, likewise.
    pub(super) box_from_midpoint: (f32, f32),
    /// Distance by which the centre of the box lies astern of the hull's centre, pixels.
    pub(super) box_astern: f32,
    /// Full axes of the silhouette, pixels.
    pub(super) major: f32,
    pub(super) minor: f32,
    /// Length and breadth of the target, pixels.
    pub(super) length: f32,
    pub(super) breadth: f32,
}

impl ReferenceSilhouette {
    /// Factors by which a later silhouette is longer and wider.
    pub(super) fn stretch_of(&self, seen: &Silhouette) -> (f32, f32) {
        (seen.major / self.major, seen.minor / self.minor)
    }
}
