//! The stage that reports: the reported box follows the network's box.
//!
//! Input: the network's box, and the target. Output: the box, and the hull's centre. The reported box follows
//! the network's box faster than the target's own box does, which the filter uses.

use barrelman_vocab::{PixelBox, PixelPoint};

use super::geometry::TargetGeometry;
use super::target::Target;
use super::time_constant::rate_in;
use crate::heading::HeadingEstimator;
use crate::vector::Rotation;

/// Settings of the reported box. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReportedBoxSettings {
    /// Time constant with which the reported box follows the network's box, seconds.
    follow_s: f64,
}

impl Default for ReportedBoxSettings {
    fn default() -> Self {
        Self { follow_s: 0.05 }
    }
}

/// The box that is reported.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ReportedBox {
    settings: ReportedBoxSettings,
    /// Its edges, from the centre of the target's own box: left, top, right, bottom, pixels. `None` before
    /// the network has evaluated the target, and while a target with a silhouette coasts. Then the own box is
    /// reported.
    edges: Option<[f32; 4]>,
}

impl ReportedBox {
    /// Reports the target's own box until the network evaluates the target again.
    pub(super) fn restart(&mut self) {
        self.edges = None;
    }

    /// Moves the box towards the network's box (left, top, right, bottom, pixels), `seconds` after the last
    /// frame.
    pub(super) fn follow(&mut self, refined: [f32; 4], geometry: &TargetGeometry, seconds: f64) {
        let (u, v) = geometry.centre;
        let mut edges = [refined[0] - u, refined[1] - v, refined[2] - u, refined[3] - v];
        if let Some(last) = self.edges {
            let rate = rate_in(seconds, self.settings.follow_s);
            for (edge, last) in edges.iter_mut().zip(last) {
                *edge = last + rate * (*edge - last);
            }
        }
        self.edges = Some(edges);
    }

    /// Converts to pixels of a picture that is larger by these factors.
    pub(super) fn rescale(&mut self, factors: (f32, f32)) {
        if let Some([left, top, right, bottom]) = &mut self.edges {
            (*left, *right) = (*left * factors.0, *right * factors.0);
            (*top, *bottom) = (*top * factors.1, *bottom * factors.1);
        }
    }

    /// The box, pixels; it may reach beyond the picture.
    pub(super) fn bounds(&self, geometry: &TargetGeometry) -> PixelBox {
        let (u, v) = geometry.centre;
        let [left, top, right, bottom] = self.edges.unwrap_or_else(|| {
            let (w, h) = geometry.upright_box();
            [-0.5 * w, -0.5 * h, 0.5 * w, 0.5 * h]
        });
        PixelBox {
            u: f64::from(u + left),
            v: f64::from(v + top),
            w: f64::from(right - left),
            h: f64::from(bottom - top),
        }
    }

    /// The hull's centre; the centre of the reported box if there is no reference silhouette.
    ///
    /// While the bow is unknown, the centre lies halfway between the ends of the colour. That is wrong if bow
    /// or stern have another paint, or if the wake has the target's colour. Once the bow is known, the centre
    /// follows from the operator's box, which contains the whole hull
    /// ([`ReferenceSilhouette::box_astern`](super::reference_silhouette::ReferenceSilhouette::box_astern)).
    pub(super) fn hull_centre(&self, target: &Target, heading: &HeadingEstimator) -> PixelPoint {
        let geometry = &target.geometry;
        let (u, v) = (f64::from(geometry.centre.0), f64::from(geometry.centre.1));
        let Some(reference) = &target.reference else {
            let [left, top, right, bottom] = self.edges.unwrap_or_default().map(f64::from);
            return PixelPoint { u: u + 0.5 * (left + right), v: v + 0.5 * (top + bottom) };
        };
        let half = geometry.half_axes();
        let certainty = heading.signed_certainty() as f32;
        let along =
            certainty * reference.box_astern - (1.0 - certainty.abs()) * reference.box_from_midpoint.0;
        let across = -reference.box_from_midpoint.1;
        let (right, down) = Rotation::by(geometry.axis)
            .apply((along * 2.0 * half.0 / reference.length, across * 2.0 * half.1 / reference.breadth));
        PixelPoint { u: u + f64::from(right), v: v + f64::from(down) }
    }
}
