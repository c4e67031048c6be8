//! The blob of the target's paint, followed from frame to frame.
//!
//! A boat that turns from bow-on to broadside grows to three times its length within two seconds. Neither the
//! filter, which looks for what it knows, nor a silhouette measured in the known ellipse follows that. The
//! blob does: it is measured in an ellipse around the blob of the last frame, and it changes little from one
//! frame to the next. A blob that changes at once contains something else, or is partly hidden, and is not
//! followed.
//!
//! While the box fits the blob, the silhouette of all colours corrects the box: it is the more exact one. The
//! blob corrects a box that does not fit, and that of a target that is too small for the silhouette.
//!
//! Input: the crop and the target's geometry. Output: a [`FollowedBlob`].

use super::geometry::TargetGeometry;
use super::ratio::is_within;
use super::reference_silhouette::ReferenceSilhouette;
use super::shape_following::{FollowingTimes, follow_shape};
use crate::crop::Crop;
use crate::paint::Paint;
use crate::silhouette::Silhouette;
use crate::vector::{difference, distance, sum};

/// Steps in which the blob is measured, each in an ellipse around the last one.
const STEPS: usize = 2;

/// Settings of the blob.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlobSettings {
    /// Time constants with which axis, centre and size follow the blob's, seconds. Not measured by itself.
    times: FollowingTimes,
    /// Half axes of the ellipse in which the blob is measured, half axes of the last blob. Not measured by
    /// itself.
    reach: f32,
    /// Added to them, pixels. Not measured by itself.
    margin_px: f32,
    /// Minimum mean share of the paint in a blob, 0 to 1. Not measured by itself.
    min_fill: f32,
    /// A blob that fills less of the ellipse of its axes than this share of what it filled at the selection
    /// contains another object of the paint beside the target, 0 to 1. Not measured by itself.
    min_fill_kept: f32,
    /// Largest factor between the areas of the blob in consecutive frames. Not measured by itself.
    max_step: f32,
    /// The same for each second without a measurement. Not measured by itself.
    max_step_per_s: f32,
    /// A blob that was not measured for longer is forgotten, seconds. Not measured by itself.
    max_age_s: f32,
    /// A first blob differs from the known length and breadth by this factor at most. Not measured by itself.
    max_first_misfit: f32,
    /// The box fits the blob up to this factor between their lengths and breadths. Not measured by itself.
    max_change: f32,
    /// The box fits the blob up to this distance of their centres, lengths of the target. Not measured by
    /// itself.
    max_off_lengths: f32,
}

impl Default for BlobSettings {
    fn default() -> Self {
        Self {
            times: FollowingTimes { axis_s: 0.1, centre_s: 0.06, size_s: 0.2 },
            reach: 1.35,
            margin_px: 2.0,
            min_fill: 0.25,
            min_fill_kept: 0.6,
            max_step: 1.25,
            max_step_per_s: 3.0,
            max_age_s: 0.5,
            max_first_misfit: 1.5,
            max_change: 1.2,
            max_off_lengths: 0.15,
        }
    }
}

/// The paint of a target, and its silhouette at the selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TargetPaint {
    pub(super) paint: Paint,
    pub(super) reference: ReferenceSilhouette,
}

/// The blob as it was last measured.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SeenBlob {
    /// From the centre of the target's box to the centroid, pixels.
    from_centre: (f32, f32),
    /// Half axes, pixels.
    half: (f32, f32),
    /// Radians clockwise from image right.
    axis: f32,
    /// Square pixels.
    area: f32,
    /// Time since the measurement, seconds.
    age_s: f32,
}

/// A blob that can be followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FollowedBlob {
    seen: Silhouette,
    /// Whether the target's box is about the blob's.
    pub(super) fits: bool,
}

/// The blob of a target.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BlobFollower {
    settings: BlobSettings,
    /// The paint, if the target has one that sets it apart.
    pub(super) paint: Option<TargetPaint>,
    last: Option<SeenBlob>,
}

impl BlobFollower {
    /// Forgets the blob: the track goes on at another place. The paint stays.
    pub(super) fn restart(&mut self) {
        self.last = None;
    }

    /// Measures the blob, `seconds` after the last frame; `None` where it is not continuous.
    pub(super) fn find(
        &mut self,
        crop: &Crop,
        geometry: &TargetGeometry,
        seconds: f32,
    ) -> Option<FollowedBlob> {
        let settings = self.settings;
        let TargetPaint { paint, reference } = self.paint?;
        let last = self.last.take().map(|blob| SeenBlob { age_s: blob.age_s + seconds, ..blob });
        let last = last.filter(|blob| blob.age_s <= settings.max_age_s);
        self.last = last;
        let (seen, fill) = self.measure(crop, &paint, geometry)?;
        let (along, across) = geometry.half_axes();
        let (length, breadth) = reference.size_of(&seen);
        let changes = (length / (2.0 * along), breadth / (2.0 * across));
        let are_within = |limit: f32| is_within(changes.0, limit) && is_within(changes.1, limit);
        let is_continuous = match last {
            Some(blob) => {
                let limit = settings.max_step * libm::powf(settings.max_step_per_s, blob.age_s - seconds);
                is_within(seen.area / blob.area, limit)
            }
            None => are_within(settings.max_first_misfit),
        };
        let is_whole = seen.fill() >= settings.min_fill_kept * reference.fill;
        if !is_continuous || !is_whole || fill < settings.min_fill {
            return None;
        }
        self.last = Some(SeenBlob {
            from_centre: difference(seen.centroid, geometry.centre),
            half: seen.half_axes(),
            axis: seen.axis,
            area: seen.area,
            age_s: 0.0,
        });
        let centre = reference.box_centre_of(&seen, geometry.axis);
        let off_px = distance(centre, geometry.centre);
        let fits = are_within(settings.max_change) && off_px <= settings.max_off_lengths * 2.0 * along;
        Some(FollowedBlob { seen, fits })
    }

    /// Corrects axis, centre, length and breadth by the blob, `seconds` after the last frame.
    pub(super) fn follow(&mut self, geometry: &mut TargetGeometry, blob: &FollowedBlob, seconds: f32) {
        let Some(TargetPaint { reference, .. }) = self.paint else { return };
        let seen = &blob.seen;
        follow_shape(geometry, &reference, seen, self.settings.times, seconds);
        if let Some(last) = &mut self.last {
            last.from_centre = difference(seen.centroid, geometry.centre);
        }
    }

    /// Measures the blob around the last one, or in the target's ellipse; with the mean share of the paint in
    /// it.
    fn measure(&self, crop: &Crop, paint: &Paint, geometry: &TargetGeometry) -> Option<(Silhouette, f32)> {
        let BlobSettings { reach, margin_px, .. } = self.settings;
        let (mut centre, mut half, mut axis) = match self.last {
            Some(blob) => (sum(geometry.centre, blob.from_centre), blob.half, blob.axis),
            None => (geometry.centre, geometry.half_axes(), geometry.axis),
        };
        let scale = paint.scale_around(crop, centre, half, axis)?.for_breadth(crop, 2.0 * half.1);
        let mut found = None;
        for _ in 0..STEPS {
            let reached = (reach * half.0 + margin_px, reach * half.1 + margin_px);
            let seen = scale.silhouette(crop, centre, reached, axis)?;
            (centre, half, axis) = (seen.centroid, seen.half_axes(), seen.axis);
            found = Some(seen);
        }
        found.map(|seen| (seen, scale.fill(crop, centre, half, axis)))
    }
}
