//! The blob of the target's paint, followed from frame to frame.
//!
//! A boat that turns from bow-on to broadside grows to three times its length within two seconds. The filter
//! and a silhouette measured in the known ellipse cannot follow this growth. The blob can: it is measured in
//! an ellipse around the blob of the last frame, and changes little between frames. A blob that changes
//! abruptly contains another object, or is partly hidden; it is not followed.
//!
//! While the box fits the blob, the silhouette of all colours corrects the box, since the silhouette is more
//! accurate. The blob corrects a box that does not fit the blob, and the box of a target that is too small
//! for the silhouette.
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

/// Settings of the blob. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlobSettings {
    /// Time constants with which axis, centre and size follow the blob's, seconds.
    times: FollowingTimes,
    /// Size of the ellipse in which the blob is measured, in sizes of the last blob.
    reach: f32,
    /// Added to the half axes of that ellipse, pixels.
    margin_px: f32,
    /// Minimum mean share of the paint in a blob, 0 to 1.
    min_fill: f32,
    /// Minimum fill of a blob, relative to its fill at the selection, 0 to 1. The *fill* is the share of the
    /// ellipse of the blob's axes. A blob with less fill contains a second object of the same paint.
    min_fill_kept: f32,
    /// Maximum ratio of the areas of the blob in consecutive frames.
    max_step: f32,
    /// Further ratio for each second without a measurement.
    max_step_per_s: f32,
    /// Maximum age of the last measured blob, seconds.
    max_age_s: f32,
    /// Maximum ratio of a first blob's length and breadth to the known ones.
    max_first_misfit: f32,
    /// Maximum ratio of the blob's length and breadth to those of a box that fits the blob.
    max_change: f32,
    /// Maximum distance of the blob's centre from that of a box that fits the blob, lengths of the target.
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

/// The last measurement of the blob.
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
    /// Whether the target's box fits the blob.
    pub(super) fits: bool,
}

/// The blob of a target.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BlobFollower {
    settings: BlobSettings,
    /// The paint, if the target has one that differs from its surroundings.
    pub(super) paint: Option<TargetPaint>,
    last: Option<SeenBlob>,
}

impl BlobFollower {
    /// Drops the last measurement, since the track continues at another place. Keeps the paint.
    pub(super) fn restart(&mut self) {
        self.last = None;
    }

    /// Measures the blob, `seconds` after the last frame. `None` if the blob changed abruptly.
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

    /// Measures the blob around the last one, otherwise in the target's ellipse. Returns the silhouette and
    /// the mean share of the paint in it.
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
