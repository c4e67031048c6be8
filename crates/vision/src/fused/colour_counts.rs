//! The colours of a target in one frame, and how well they match what was learned.

use barrelman_vocab::Picture;

use super::appearance::Appearance;
use super::extent::Extent;
use crate::colour_model::{ColourHistogram, count_colours};
use crate::layout::ColourLayout;
use crate::vector::Vector;

/// Histograms in and around a target's ellipse, and the layout of the colours in the ellipse.
#[derive(Debug, Default)]
pub(super) struct ColourCounts {
    pub(super) inside: ColourHistogram,
    pub(super) ring: ColourHistogram,
    pub(super) layout: ColourLayout,
}

impl ColourCounts {
    /// Counts the colours of a target with its centre here (pixels), `scale` times as large as its extent,
    /// with its axis at `axis`.
    pub(super) fn count(
        &mut self,
        picture: &Picture,
        centre: Vector,
        extent: &Extent,
        scale: f32,
        axis: f32,
    ) {
        count_colours(picture, centre, &extent.ellipse(scale, axis), &mut self.inside, &mut self.ring);
        self.layout.count(picture, centre, extent.half_axes(scale), axis);
    }

    /// Similarity (Bhattacharyya coefficient) of the colours to the learned ones, 0 to 1.
    pub(super) fn similarity(&self, appearance: &Appearance) -> f32 {
        self.inside.similarity(&appearance.colours.target)
    }

    /// The same of their layout: the mean of the parts.
    pub(super) fn layout_similarity(&self, appearance: &Appearance) -> f32 {
        self.layout.similarity(&appearance.layout)
    }
}
