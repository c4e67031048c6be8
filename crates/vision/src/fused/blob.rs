//! The blob of the target's paint, followed from frame to frame.
//!
//! A boat that turns from bow-on to broadside grows to three times its length within two seconds. Neither the filter,
//! which looks for what it knows, nor a silhouette measured in the known ellipse follows that. The blob does: it is
//! measured in an ellipse around the blob of the last frame, and it changes little from one frame to the next. A blob
//! that changes at once contains something else, or is partly hidden, and is not followed.
//!
//! While the box fits the blob, the silhouette of all colours corrects the box: it is the more exact one. The blob
//! corrects a box that does not fit, and that of a target that is too small for the silhouette.

use super::geometry::TargetGeometry;
use super::refining::SILHOUETTE_REACH;
use super::shape_following::{FollowingTimes, follow_shape, is_within};
use super::target::Target;
use super::target_paint::{SeenBlob, TargetPaint};
use super::workspace::Workspace;
use crate::paint::Paint;
use crate::silhouette::Silhouette;

/// Time constants with which axis, centre and size follow the blob's, seconds.
const TIMES: FollowingTimes = FollowingTimes { axis_s: 0.1, centre_s: 0.06, size_s: 0.2 };
/// Steps in which the blob is measured, each in an ellipse around the last one.
const STEPS: usize = 2;
/// Half axes of the ellipse exceed the blob's by the factor [`SILHOUETTE_REACH`] and by this many pixels.
const MARGIN_PX: f32 = 2.0;
/// Minimum mean share of the paint in a blob.
const MIN_FILL: f32 = 0.25;
/// A blob that fills less of the ellipse of its axes than this share of what it filled at the selection contains another
/// thing of the paint beside the target.
const MIN_FILL_KEPT: f32 = 0.6;
/// Largest factor between the areas of the blob in consecutive frames, and the factor per second without a measurement.
const MAX_STEP: f32 = 1.25;
const MAX_STEP_PER_S: f32 = 3.0;
/// A blob that was not measured for longer is forgotten, seconds.
const MAX_AGE_S: f32 = 0.5;
/// A first blob differs from the known length and breadth by this factor at most.
const MAX_FIRST_MISFIT: f32 = 1.5;

/// The box fits the blob up to this factor between their lengths and breadths, and this distance of their centres, in
/// lengths of the target.
const MAX_CHANGE: f32 = 1.2;
const MAX_OFF_LENGTHS: f32 = 0.15;

/// A blob that can be followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FollowedBlob {
    seen: Silhouette,
    /// Whether the target's box is about the blob's.
    pub(super) fits: bool,
}

impl Workspace {
    /// Measures the blob, `seconds` after the last frame; `None` where it is not continuous.
    pub(super) fn find_blob(&self, target: &mut Target, seconds: f32) -> Option<FollowedBlob> {
        let TargetPaint { paint, reference } = target.paint?;
        let last = target.blob.take().map(|blob| SeenBlob { age_s: blob.age_s + seconds, ..blob });
        let last = last.filter(|blob| blob.age_s <= MAX_AGE_S);
        target.blob = last;
        let geometry = &target.geometry;
        let (seen, fill) = self.measure_blob(&paint, geometry, last.as_ref())?;
        let (along, across) = geometry.half_axes();
        let (length, breadth) = reference.size_of(&seen);
        let changes = (length / (2.0 * along), breadth / (2.0 * across));
        let is_continuous = match last {
            Some(blob) => {
                let limit = MAX_STEP * libm::powf(MAX_STEP_PER_S, blob.age_s - seconds);
                is_within(seen.area / blob.area, limit)
            }
            None => is_within(changes.0, MAX_FIRST_MISFIT) && is_within(changes.1, MAX_FIRST_MISFIT),
        };
        let is_whole = seen.fill() >= MIN_FILL_KEPT * reference.fill;
        if !is_continuous || !is_whole || fill < MIN_FILL {
            return None;
        }
        target.blob = Some(SeenBlob {
            from_centre: (seen.centroid.0 - geometry.centre.0, seen.centroid.1 - geometry.centre.1),
            half: (0.5 * seen.major, 0.5 * seen.minor),
            axis: seen.axis,
            area: seen.area,
            age_s: 0.0,
        });
        let centre = reference.box_centre_of(&seen, geometry.axis);
        let off = libm::hypotf(centre.0 - geometry.centre.0, centre.1 - geometry.centre.1);
        let fits = is_within(changes.0, MAX_CHANGE)
            && is_within(changes.1, MAX_CHANGE)
            && off <= MAX_OFF_LENGTHS * 2.0 * along;
        Some(FollowedBlob { seen, fits })
    }

    /// Corrects axis, centre, length and breadth by the blob, `seconds` after the last frame.
    pub(super) fn follow_blob(target: &mut Target, blob: &FollowedBlob, seconds: f32) {
        let Some(TargetPaint { reference, .. }) = target.paint else { return };
        let (geometry, seen) = (&mut target.geometry, &blob.seen);
        follow_shape(geometry, &reference, seen, TIMES, seconds);
        if let Some(last) = &mut target.blob {
            last.from_centre = (seen.centroid.0 - geometry.centre.0, seen.centroid.1 - geometry.centre.1);
        }
    }

    /// Measures the blob around the last one, or in the target's ellipse; with the mean share of the paint in it.
    fn measure_blob(
        &self,
        paint: &Paint,
        geometry: &TargetGeometry,
        last: Option<&SeenBlob>,
    ) -> Option<(Silhouette, f32)> {
        let (mut centre, mut half, mut axis) = match last {
            Some(blob) => (
                (geometry.centre.0 + blob.from_centre.0, geometry.centre.1 + blob.from_centre.1),
                blob.half,
                blob.axis,
            ),
            None => (geometry.centre, geometry.half_axes(), geometry.axis),
        };
        let scale = paint.scale_around(&self.crop, centre, half, axis)?.for_breadth(&self.crop, 2.0 * half.1);
        let mut found = None;
        for _ in 0..STEPS {
            let reach = (SILHOUETTE_REACH * half.0 + MARGIN_PX, SILHOUETTE_REACH * half.1 + MARGIN_PX);
            let seen = scale.silhouette(&self.crop, centre, reach, axis)?;
            (centre, half, axis) = (seen.centroid, (0.5 * seen.major, 0.5 * seen.minor), seen.axis);
            found = Some(seen);
        }
        found.map(|seen| (seen, scale.fill(&self.crop, centre, half, axis)))
    }
}
