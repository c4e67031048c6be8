//! The silhouette at the selection, with which later silhouettes are compared.

use crate::silhouette::Silhouette;
use crate::vector::{Rotation, Vector, difference};

/// The upright box around a hull at an angle touches the point of the bow at one corner and the corners of
/// the blunt stern on two sides. The box's centre therefore lies astern of the hull's, by
/// ([`ASTERN_CONSTANT`] + [`ASTERN_SLOPE`] |cos sin|) |cos sin| breadths, with cosine and sine of the hull's
/// axis. The formula holds to within 0.02 breadths for hulls two to five times as long as wide whose bow,
/// slender or full, tapers from the middle on.
const ASTERN_CONSTANT: f32 = 0.22;
const ASTERN_SLOPE: f32 = 0.34;

/// The target's shape by its colour at the selection, and its relation to the operator's box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ReferenceSilhouette {
    /// From the centroid of the colour to the centre of the box, pixels along the axis and across it
    /// (clockwise).
    pub(super) box_from_centroid: (f32, f32),
    /// From the midpoint between the ends of the colour to the centre of the box, likewise.
    pub(super) box_from_midpoint: (f32, f32),
    /// Distance by which the centre of the box lies astern of the hull's centre, pixels.
    pub(super) box_astern: f32,
    /// Full axes of the silhouette, pixels.
    pub(super) major: f32,
    pub(super) minor: f32,
    /// Share of the ellipse of its axes that the silhouette filled.
    pub(super) fill: f32,
    /// Length and breadth of the target, pixels.
    pub(super) length: f32,
    pub(super) breadth: f32,
}

impl ReferenceSilhouette {
    /// The silhouette of a hull of this length and breadth (pixels) with its box around `centre` and this
    /// axis, radians clockwise from image right.
    pub(super) fn of_hull(
        seen: &Silhouette,
        (length, breadth): (f32, f32),
        centre: (f32, f32),
        axis: f32,
    ) -> Self {
        let turn = Rotation::by(axis);
        let box_from = |from: Vector| turn.undo(difference(centre, from));
        let slant = (turn.cos * turn.sin).abs();
        Self {
            box_from_centroid: box_from(seen.centroid),
            box_from_midpoint: box_from(seen.midpoint),
            box_astern: (ASTERN_CONSTANT + ASTERN_SLOPE * slant) * breadth * slant,
            major: seen.major,
            minor: seen.minor,
            fill: seen.fill(),
            length,
            breadth,
        }
    }

    /// Factors by which a later silhouette is longer and wider.
    pub(super) fn stretch_of(&self, seen: &Silhouette) -> (f32, f32) {
        (seen.major / self.major, seen.minor / self.minor)
    }

    /// Length and breadth of the target by a later silhouette, pixels.
    pub(super) fn size_of(&self, seen: &Silhouette) -> (f32, f32) {
        let (longer, wider) = self.stretch_of(seen);
        (self.length * longer, self.breadth * wider)
    }

    /// Centre of the box around a later silhouette of a target with this axis, pixels.
    pub(super) fn box_centre_of(&self, seen: &Silhouette, axis: f32) -> (f32, f32) {
        let (longer, wider) = self.stretch_of(seen);
        let (forward, aside) = self.box_from_centroid;
        Rotation::by(axis).place_from(seen.centroid, (forward * longer, aside * wider))
    }
}
