//! The stage that measures a selection: colours, silhouette and paint in the box that the operator dragged,
//! and whether another box is better.
//!
//! The silhouette of the paint has subpixel accuracy; an operator's box has not. If the difference of the two
//! is within the error of a hand-drawn box, the box around the paint is used. If the difference is larger,
//! the paint is only a part of the target, and the relation of box and paint is kept.
//!
//! Input: the crop and the box. Output: the target's extent, reference silhouette and paint, and the used
//! box.

use barrelman_vocab::PixelBox;

use super::blob::TargetPaint;
use super::extent::{Extent, upright_box_of};
use super::ratio::is_within;
use super::reference_silhouette::ReferenceSilhouette;
use super::target::Target;
use crate::crop::Crop;
use crate::paint::Paint;
use crate::refinement::RefinedBox;
use crate::silhouette::Silhouette;

/// Half axes of the ellipse around the selection's box, in half sides of the box. A corner is 1.41 half sides
/// from the centre.
const BOX_ELLIPSE: f32 = 1.42;

/// Settings of the selection. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct SelectionSettings {
    /// Minimum target probability of a coloured pixel, 0 to 255.
    min_coloured_probability: u8,
    /// Minimum contrast of a trusted silhouette at the selection, 0 to 1. Size and axis are measured by
    /// trusted silhouettes only.
    min_trusted_contrast: f32,
    /// Maximum ratio of the sides of a trusted silhouette's upright box to those of the operator's box.
    max_trusted_stretch: f32,
    /// Minimum share of its ellipse that a trusted silhouette fills, 0 to 1.
    min_trusted_fill: f32,
    /// Minimum probability of a refined box that replaces a dragged one, 0 to 1.
    min_tightening_probability: f32,
    /// Minimum width and height of a box that replaces a dragged one, pixels.
    min_tightened_px: (f64, f64),
    /// Minimum IoU of dragged and refined box with which the dragged box is kept, 0 to 1. With a larger IoU,
    /// the refined box is used only if it has a trusted silhouette and the dragged box has none.
    min_kept_iou: f64,
    /// Maximum share of the paint in the surroundings when it is learned, 0 to 1.
    max_unpainted_share: f32,
    /// Sides of a hull relative to the full axes of an ellipse with the same moments: 0.87 for a rectangle, 1
    /// for an ellipse.
    hull_axes: f32,
    /// Minimum mean share of the paint in the ellipse of its silhouette, 0 to 1.
    min_painted_fill: f32,
    /// Minimum sides of a dragged box, in sides of the box around the paint.
    min_dragged: f32,
    /// Maximum of the same sides.
    max_dragged: f32,
    /// Maximum distance of the centres of both boxes, in sides of the box around the paint.
    max_dragged_offset: f64,
}

impl Default for SelectionSettings {
    fn default() -> Self {
        Self {
            min_coloured_probability: 128,
            min_trusted_contrast: 0.5,
            max_trusted_stretch: 1.25,
            min_trusted_fill: 0.5,
            min_tightening_probability: 0.5,
            min_tightened_px: (6.0, 4.0),
            min_kept_iou: 0.7,
            max_unpainted_share: 0.25,
            hull_axes: 0.92,
            min_painted_fill: 0.35,
            min_dragged: 0.75,
            max_dragged: 1.6,
            max_dragged_offset: 0.25,
        }
    }
}

/// How distinct the colours of a selection are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SelectionColours {
    /// Share of the selection's pixels whose colour is more likely the target's than the surroundings', 0 to
    /// 1.
    pub(super) coloured_share: f64,
    /// Mean target probability in the ring around the selection, 0 to 1.
    pub(super) surroundings_probability: f64,
}

/// Which box is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BoxChoice {
    /// The dragged one.
    Dragged,
    /// The refined one.
    Refined,
    /// The refined one if it gives a trusted silhouette, otherwise the dragged one.
    RefinedWithSilhouette,
}

/// The measurement of selections.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Selection {
    settings: SelectionSettings,
}

impl Selection {
    /// Measures how distinct the colours in a box (width and height, pixels) around the target are, and sets
    /// the target's extent and reference silhouette. Also returns the target's paint, if it differs from the
    /// surroundings.
    pub(super) fn measure(
        &self,
        crop: &Crop,
        target: &mut Target,
        box_size: (f32, f32),
    ) -> (SelectionColours, Option<TargetPaint>) {
        let half = (0.5 * box_size.0, 0.5 * box_size.1);
        let centre = target.geometry.centre;
        let contrast = crop.contrast(centre, half, 0.0);
        let ellipse = ellipse_around_box(half);
        let coloured_share = self.coloured_share(crop, centre, half);
        let silhouette = Silhouette::measure(crop, centre, ellipse, 0.0, contrast).filter(|seen| {
            let contrast = crop.contrast(seen.centroid, seen.half_axes(), seen.axis);
            contrast.difference() >= self.settings.min_trusted_contrast
        });
        let extent = Extent::from_selection(box_size, silhouette.as_ref());
        target.geometry.extent = extent;
        target.geometry.axis = extent.axis().unwrap_or(0.0);
        target.reference =
            silhouette.and_then(|seen| self.reference(&seen, &extent, centre, target.geometry.axis));
        let paint = self.measure_paint(crop, target, box_size);
        if target.reference.is_none() {
            // Without a silhouette, the refinement follows an upright box.
            target.geometry.extent = Extent::Box { width: box_size.0, height: box_size.1 };
            target.geometry.axis = 0.0;
        }
        let contrast = crop.contrast(centre, target.geometry.half_axes(), target.geometry.axis);
        target.appearance.usual.contrast = contrast.difference();
        (SelectionColours { coloured_share, surroundings_probability: f64::from(contrast.ring) }, paint)
    }

    /// Share of the pixels of a box with these half sides whose colour is more likely the target's than the
    /// surroundings'.
    fn coloured_share(&self, crop: &Crop, centre: (f32, f32), half: (f32, f32)) -> f64 {
        let (mut coloured, mut count) = (0_u32, 0_u32);
        crop.for_each_probability(centre, ellipse_around_box(half), 0.0, |du, dv, probability| {
            if du.abs() <= half.0 && dv.abs() <= half.1 {
                coloured += u32::from(probability >= self.settings.min_coloured_probability);
                count += 1;
            }
        });
        if count == 0 { 0.0 } else { f64::from(coloured) / f64::from(count) }
    }

    /// Learns the paint in the box of a selection, width and height in pixels, and the silhouette's relation
    /// to the box. A target without a trusted silhouette of its colours may get one of its paint.
    fn measure_paint(&self, crop: &Crop, target: &mut Target, box_size: (f32, f32)) -> Option<TargetPaint> {
        let centre = target.geometry.centre;
        let (paint, seen) = self.find_paint(crop, centre, (0.5 * box_size.0, 0.5 * box_size.1))?;
        if target.reference.is_none() {
            let extent = Extent::from_selection(box_size, Some(&seen));
            let axis = extent.axis().unwrap_or(0.0);
            target.reference = self.reference(&seen, &extent, centre, axis);
            if target.reference.is_some() {
                (target.geometry.extent, target.geometry.axis) = (extent, axis);
            }
        }
        target.reference?;
        let Extent::Hull { length, breadth, .. } = target.geometry.extent else { return None };
        let axis = target.geometry.axis;
        let reference = ReferenceSilhouette::of_hull(&seen, (length, breadth), centre, axis);
        Some(TargetPaint { paint, reference })
    }

    /// The reference silhouette of a selection with its box around `centre`, if the silhouette can be
    /// trusted.
    fn reference(
        &self,
        seen: &Silhouette,
        extent: &Extent,
        centre: (f32, f32),
        axis: f32,
    ) -> Option<ReferenceSilhouette> {
        let Extent::Hull { length, breadth, stretch, .. } = *extent else { return None };
        let matches_box = |stretch: f32| is_within(stretch, self.settings.max_trusted_stretch);
        let fill = seen.area / (0.25 * core::f32::consts::PI * length * breadth);
        let is_trusted =
            matches_box(stretch.0) && matches_box(stretch.1) && fill >= self.settings.min_trusted_fill;
        is_trusted.then(|| ReferenceSilhouette::of_hull(seen, (length, breadth), centre, axis))
    }

    /// The paint in a box of this centre and these half sides, and its silhouette.
    fn find_paint(&self, crop: &Crop, centre: (f32, f32), half: (f32, f32)) -> Option<(Paint, Silhouette)> {
        let settings = &self.settings;
        let ellipse = ellipse_around_box(half);
        let paint = Paint::find(crop, centre, half)?;
        let scale = paint.scale_around(crop, centre, ellipse, 0.0)?;
        let seen = scale.silhouette(crop, centre, ellipse, 0.0)?;
        let scale = scale.for_breadth(crop, seen.minor);
        let seen = scale.silhouette(crop, centre, ellipse, 0.0)?;
        let fill = scale.fill(crop, seen.centroid, seen.half_axes(), seen.axis);
        (fill >= settings.min_painted_fill && scale.ring <= settings.max_unpainted_share)
            .then_some((paint, seen))
    }

    /// The upright box around the paint in a dragged box. `None` if the two differ by more than the error of
    /// a hand-drawn box, or if the refined box overlaps the dragged one more: then the paint is a part of the
    /// target.
    pub(super) fn painted_box(&self, crop: &Crop, dragged: PixelBox, refined: PixelBox) -> Option<PixelBox> {
        let settings = &self.settings;
        let (w, h) = (dragged.w as f32, dragged.h as f32);
        let middle = dragged.centre();
        let (_, seen) = self.find_paint(crop, (middle.u as f32, middle.v as f32), (0.5 * w, 0.5 * h))?;
        let (width, height) =
            upright_box_of(settings.hull_axes * seen.major, settings.hull_axes * seen.minor, seen.axis);
        let is_near = |dragged: f32, painted: f32, off: f64| {
            (settings.min_dragged..=settings.max_dragged).contains(&(dragged / painted))
                && off.abs() <= settings.max_dragged_offset * f64::from(painted)
        };
        let (u, v) = (f64::from(seen.centroid.0), f64::from(seen.centroid.1));
        let is_explained = is_near(w, width, u - middle.u) && is_near(h, height, v - middle.v);
        let (width, height) = (f64::from(width), f64::from(height));
        let painted = PixelBox { u: u - 0.5 * width, v: v - 0.5 * height, w: width, h: height };
        let is_better = refined.iou(painted) > refined.iou(dragged);
        (is_explained && self.is_large_enough(painted) && is_better).then_some(painted)
    }

    /// Which of two boxes is used, the dragged one or the refined one within the picture. `has_silhouette`:
    /// whether the dragged one gives a trusted silhouette.
    pub(super) fn choose(
        &self,
        dragged: PixelBox,
        refined: &RefinedBox,
        bounds: PixelBox,
        has_silhouette: bool,
    ) -> BoxChoice {
        let is_plausible =
            refined.probability > self.settings.min_tightening_probability && self.is_large_enough(bounds);
        if !is_plausible {
            BoxChoice::Dragged
        } else if bounds.iou(dragged) < self.settings.min_kept_iou {
            BoxChoice::Refined
        } else if has_silhouette {
            BoxChoice::Dragged
        } else {
            BoxChoice::RefinedWithSilhouette
        }
    }

    fn is_large_enough(&self, bounds: PixelBox) -> bool {
        let (width, height) = self.settings.min_tightened_px;
        bounds.w >= width && bounds.h >= height
    }
}

/// Half axes of an ellipse that contains a box with these half sides.
pub(super) fn ellipse_around_box(half: (f32, f32)) -> (f32, f32) {
    (BOX_ELLIPSE * half.0, BOX_ELLIPSE * half.1)
}
