//! The stage that measures size, rotation and centre of a target that was found in the frame: its *own box*,
//! which filter and silhouette use.
//!
//! Input: the crop, the observation, the filter's size and rotation, and the network's edges. Output: the
//! target's geometry. State: the paint, its blob, and the contradictions of the network's box.

use super::blob::BlobFollower;
use super::contradiction::Contradiction;
use super::geometry::TargetGeometry;
use super::later_axis::LaterAxis;
use super::observation::Observation;
use super::observer::PoseChange;
use super::ratio::is_within;
use super::seen_axis::SeenAxis;
use super::shape_following::{FollowingTimes, follow_shape};
use super::target::Target;
use crate::crop::Crop;
use crate::refinement::{RefinedBox, RefinementWindow};
use crate::silhouette::Silhouette;

/// Settings of the own box. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShapeSettings {
    /// Minimum relative contrast of a target with a silhouette that may grow by the filter, 0 to 1. With
    /// less, the box already contains background, and the filter has learned the target together with another
    /// object that moves away. Without this setting, 0.106 of `clips-more` are lost instead of 0.100.
    min_growing_contrast: f32,
    /// Time constants with which axis, centre and size follow the silhouette's, seconds.
    times: FollowingTimes,
    /// Size of the ellipse in which the silhouette is measured, in sizes of the target's ellipse.
    reach: f32,
    /// Minimum share of the ellipse of its axes that a silhouette of a single object fills, 0 to 1. Without
    /// this setting, 0.105 of `clips-more` are lost instead of 0.100.
    min_fill: f32,
    /// Maximum ratio of length and breadth of a silhouette without other objects to the target's.
    max_misfit: f32,
    /// Minimum probability of a refined box whose edges are followed, 0 to 1.
    min_edge_probability: f32,
    /// Minimum probability of a refined box whose edges are followed at the full rate, 0 to 1.
    full_edge_probability: f32,
    /// Maximum share of the distance to the refined edge that an edge moves in a frame, 0 to 1.
    max_edge_rate: f32,
    /// Expected error of an edge that moves at half the rate, sides.
    edge_drift: f32,
    /// Maximum step of an edge in a frame, sides.
    max_edge_step: f32,
    /// Maximum distance of the box from the filter's response, sizes.
    max_offset_sizes: f32,
    /// Share of a change of the box that the filter's size follows in a frame, 0 to 1.
    size_share: f32,
}

impl Default for ShapeSettings {
    fn default() -> Self {
        Self {
            min_growing_contrast: 0.6,
            times: FollowingTimes { axis_s: 0.15, centre_s: 0.3, size_s: 1.0 },
            reach: 1.35,
            min_fill: 0.7,
            max_misfit: 1.5,
            min_edge_probability: 0.1,
            full_edge_probability: 0.5,
            max_edge_rate: 0.5,
            edge_drift: 0.02,
            max_edge_step: 0.2,
            max_offset_sizes: 1.0,
            size_share: 0.06,
        }
    }
}

/// The shape of a target.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shape {
    settings: ShapeSettings,
    pub(super) blob: BlobFollower,
    /// Followed without a silhouette at the selection.
    pub(super) later_axis: LaterAxis,
    contradiction: Contradiction,
}

impl Shape {
    /// The target's axis, if it is known.
    pub(super) fn axis(&self, geometry: &TargetGeometry) -> Option<SeenAxis> {
        let (along, across) = geometry.half_axes();
        match geometry.extent.axis() {
            Some(_) => Some(SeenAxis { angle: geometry.axis, sides: (2.0 * along, 2.0 * across) }),
            None => self.later_axis.seen(),
        }
    }

    /// Follows size, rotation and centre, `seconds` after the last frame.
    pub(super) fn follow(
        &mut self,
        target: &mut Target,
        crop: &Crop,
        observation: &Observation,
        change: PoseChange,
        seconds: f32,
    ) {
        let Target { geometry, reference, .. } = target;
        let may_grow = reference.is_none() || observation.has_its_colour(self.settings.min_growing_contrast);
        if may_grow || change.scale_factor < 1.0 {
            geometry.rescale(change.scale_factor);
        }
        geometry.turn(change.turn);
        // The silhouette of all colours is more accurate, unless the target is too small for it.
        match self.blob.find(crop, &target.geometry, seconds) {
            Some(blob) if !blob.fits => self.blob.follow(&mut target.geometry, &blob, seconds),
            blob => {
                let is_followed = self.follow_silhouette(target, crop, observation, seconds);
                if let Some(blob) = blob.filter(|_| !is_followed) {
                    self.blob.follow(&mut target.geometry, &blob, seconds);
                }
            }
        }
    }

    /// Corrects the drift of axis, centre, length and breadth by the silhouette. Returns whether a fitting
    /// silhouette was measured.
    fn follow_silhouette(
        &self,
        target: &mut Target,
        crop: &Crop,
        observation: &Observation,
        seconds: f32,
    ) -> bool {
        let settings = &self.settings;
        let geometry = &mut target.geometry;
        let Some(reference) = target.reference else { return false };
        let (along, across) = geometry.half_axes();
        let half = (settings.reach * along, settings.reach * across);
        let Some(seen) =
            Silhouette::measure(crop, geometry.centre, half, geometry.axis, observation.contrast)
        else {
            return false;
        };
        if seen.fill() < settings.min_fill {
            return false;
        }
        let (length, breadth) = reference.size_of(&seen);
        let fits = |measured: f32, known: f32| is_within(measured / known, settings.max_misfit);
        if !(fits(length, 2.0 * along) && fits(breadth, 2.0 * across)) || geometry.touches_border() {
            return false;
        }
        follow_shape(geometry, &reference, &seen, settings.times, seconds);
        true
    }

    /// Moves a box with a silhouette onto the network's box if that contradicts it. Returns whether it did;
    /// then the filter has to be retrained.
    pub(super) fn correct_contradicted_box(
        &mut self,
        target: &mut Target,
        refined: &RefinedBox,
        seconds: f32,
    ) -> bool {
        let geometry = &mut target.geometry;
        if target.reference.is_none() {
            return false;
        }
        let [left, top, right, bottom] = refined.edges;
        let (w, h) = geometry.upright_box();
        let share = (right - left) * (bottom - top) / (w * h);
        if !self.contradiction.is_confirmed(w * h, share, refined.probability, seconds) {
            return false;
        }
        geometry.centre = (0.5 * (left + right), 0.5 * (top + bottom));
        geometry.rescale(share.sqrt());
        self.blob.restart();
        true
    }

    /// Moves the edges of a target without a silhouette towards the refined ones, which were read from this
    /// window. An edge with a smaller expected error moves faster. `place` is that of the filter's response,
    /// pixels.
    pub(super) fn follow_refined_box(
        &self,
        target: &mut Target,
        refined: &RefinedBox,
        window: &RefinementWindow,
        place: (f32, f32),
    ) {
        if target.reference.is_some() {
            return;
        }
        let (settings, geometry) = (&self.settings, &mut target.geometry);
        let certainty = ((refined.probability - settings.min_edge_probability)
            / (settings.full_edge_probability - settings.min_edge_probability))
            .clamp(0.0, 1.0);
        let (width, height) = window.box_size;
        let mut edges = window.box_edges();
        for (index, edge) in edges.iter_mut().enumerate() {
            let error = refined.errors[index] / settings.edge_drift;
            let rate = certainty * settings.max_edge_rate / (1.0 + error * error);
            let limit = settings.max_edge_step * if index % 2 == 0 { width } else { height };
            *edge += (rate * (refined.edges[index] - *edge)).clamp(-limit, limit);
        }
        let [left, top, right, bottom] = edges;
        let (u, v) = window.centre;
        let size = geometry.size_px();
        let max_offset = settings.max_offset_sizes;
        let moved = |offset: f32, from: f32, to: f32, old: f32| {
            (offset + (0.5 * (from + to) - old) / size).clamp(-max_offset, max_offset)
        };
        geometry.offset =
            (moved(geometry.offset.0, left, right, u), moved(geometry.offset.1, top, bottom, v));
        geometry.reshape_box((right - left) / width, (bottom - top) / height, settings.size_share);
        geometry.centre = geometry.box_centre_at(place);
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PixelBox;

    use super::super::test_target::{red_on_blue, selected};
    use super::*;

    const FRAME_S: f32 = 1.0 / 30.0;

    #[test]
    fn a_contradicted_box_is_moved_onto_the_networks() {
        let is_boat = |column, row| (100..130).contains(&column) && (60..72).contains(&row);
        let boat = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };
        let (mut follower, _) = selected(red_on_blue((240, 160), is_boat), boat);
        let (shape, target) = (&mut follower.shape, &mut follower.target);
        assert!(target.reference.is_some());
        let refined =
            RefinedBox { edges: [100.0, 60.0, 130.0, 72.0], probability: 0.9, ..RefinedBox::default() };
        assert!(!shape.correct_contradicted_box(target, &refined, FRAME_S));
        target.geometry.rescale(2.0);
        target.geometry.centre = (130.0, 70.0);
        let mut frames = 0;
        while !shape.correct_contradicted_box(target, &refined, FRAME_S) {
            assert_eq!(target.geometry.centre, (130.0, 70.0));
            frames += 1;
            assert!(frames < 10, "the box is not moved");
        }
        assert_eq!(target.geometry.centre, (115.0, 66.0));
        let (w, h) = target.geometry.upright_box();
        assert!((w * h / 360.0 - 1.0).abs() < 0.05, "{w} x {h}");
    }
}
