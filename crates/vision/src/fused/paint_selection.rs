//! The paint of a target that is selected.
//!
//! The silhouette of the paint is exact to a part of a pixel, an operator's box is not. Where a hand explains how the two
//! differ, the box around the paint is used. Where it does not, the paint is only a part of the target, and the relation
//! of box and paint is kept.

use barrelman_vocab::PixelBox;

use super::extent::{Extent, upright_box_of};
use super::learning::{BOX_ELLIPSE, MIN_TIGHTENED_PX, reference_silhouette};
use super::reference_silhouette::ReferenceSilhouette;
use super::target::Target;
use super::target_paint::TargetPaint;
use super::workspace::Workspace;
use crate::paint::Paint;
use crate::silhouette::Silhouette;

/// Maximum share of the paint in the surroundings when it is learned.
const MAX_UNPAINTED_SHARE: f32 = 0.25;
/// Sides of a hull, in full axes of an ellipse with the same moments: 0.87 for a rectangle, 1 for an ellipse.
const HULL_AXES: f32 = 0.92;
/// Minimum mean share of the paint in the ellipse of its silhouette.
const MIN_PAINTED_FILL: f32 = 0.35;
/// Sides of a box that the operator dragged, in sides of the box around the paint, and the largest distance of its centre.
const MIN_DRAGGED: f32 = 0.75;
const MAX_DRAGGED: f32 = 1.6;
const MAX_DRAGGED_OFFSET: f64 = 0.25;

impl Workspace {
    /// Learns the paint in the box of a selection, width and height in pixels, and the silhouette's relation to the box.
    /// A target without a trusted silhouette of its colours may get one of its paint.
    pub(super) fn learn_paint(&self, target: &mut Target, box_size: (f32, f32)) {
        let centre = target.geometry.centre;
        let Some((paint, seen)) = self.find_paint(centre, (0.5 * box_size.0, 0.5 * box_size.1)) else {
            return;
        };
        if target.reference.is_none() {
            let extent = Extent::from_selection(box_size, Some(&seen));
            let axis = extent.axis().unwrap_or(0.0);
            target.reference = reference_silhouette(&seen, &extent, centre, axis);
            if target.reference.is_some() {
                (target.geometry.extent, target.geometry.axis) = (extent, axis);
                target.loss.reliable_size = (1.0, extent);
            }
        }
        if target.reference.is_some()
            && let Extent::Hull { length, breadth, .. } = target.geometry.extent
        {
            let reference =
                ReferenceSilhouette::of_hull(&seen, (length, breadth), centre, target.geometry.axis);
            target.paint = Some(TargetPaint { paint, reference });
        }
    }

    /// The paint in a box of this centre and these half sides, and its silhouette.
    fn find_paint(&self, centre: (f32, f32), half: (f32, f32)) -> Option<(Paint, Silhouette)> {
        let ellipse = (BOX_ELLIPSE * half.0, BOX_ELLIPSE * half.1);
        let paint = Paint::find(&self.crop, centre, half)?;
        let scale = paint.scale_around(&self.crop, centre, ellipse, 0.0)?;
        let seen = scale.silhouette(&self.crop, centre, ellipse, 0.0)?;
        let scale = scale.for_breadth(&self.crop, seen.minor);
        let seen = scale.silhouette(&self.crop, centre, ellipse, 0.0)?;
        let own = (0.5 * seen.major, 0.5 * seen.minor);
        let fill = scale.fill(&self.crop, seen.centroid, own, seen.axis);
        (fill >= MIN_PAINTED_FILL && scale.ring <= MAX_UNPAINTED_SHARE).then_some((paint, seen))
    }

    /// The upright box around the paint in a dragged box, where the operator's hand explains the difference.
    pub(super) fn painted_box(&self, dragged: PixelBox) -> Option<PixelBox> {
        let (w, h) = (dragged.w as f32, dragged.h as f32);
        let middle = dragged.centre();
        let (_, seen) = self.find_paint((middle.u as f32, middle.v as f32), (0.5 * w, 0.5 * h))?;
        let (width, height) = painted_box_size(&seen);
        let is_near = |dragged: f32, painted: f32, off: f64| {
            (MIN_DRAGGED..=MAX_DRAGGED).contains(&(dragged / painted))
                && off.abs() <= MAX_DRAGGED_OFFSET * f64::from(painted)
        };
        let (u, v) = (f64::from(seen.centroid.0), f64::from(seen.centroid.1));
        let is_explained = is_near(w, width, u - middle.u) && is_near(h, height, v - middle.v);
        let (width, height) = (f64::from(width), f64::from(height));
        (is_explained && width >= MIN_TIGHTENED_PX.0 && height >= MIN_TIGHTENED_PX.1).then_some(PixelBox {
            u: u - 0.5 * width,
            v: v - 0.5 * height,
            w: width,
            h: height,
        })
    }
}

/// Width and height of the upright box around a silhouette of paint, pixels.
fn painted_box_size(seen: &Silhouette) -> (f32, f32) {
    upright_box_of(HULL_AXES * seen.major, HULL_AXES * seen.minor, seen.axis)
}
