//! The stage that notices a box with a silhouette that slipped off its target while the filter adapted.
//!
//! Filter and silhouette are evaluated at the box. Once the box covers a part of the target, or its wake,
//! both confirm that. Therefore the blob of the target's colour is followed at intervals from the box to its
//! ends. If the box has much less contrast than the blob in several consecutive checks, the blob is the
//! target. Another object of the same colour beside the target has no effect, since the target's own box
//! keeps its contrast.
//!
//! Input: the crop and the target's geometry. Output: the silhouette of the blob onto which the box has to
//! move.

use super::geometry::TargetGeometry;
use crate::crop::{ColourContrast, Crop};
use crate::silhouette::Silhouette;

/// Settings of the check.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlippedBoxSettings {
    /// Interval at which the blob is measured, frames with the target found. Not measured by itself.
    interval: u32,
    /// Number of steps in which it is measured. Not measured by itself.
    steps: usize,
    /// Least half axes of the ellipses in which it is measured, pixels. Not measured by itself.
    min_half_px: f32,
    /// Half axes of the ellipses, half axes of the last blob. Not measured by itself.
    reach: f32,
    /// The pixels of the blob are those whose target probability is nearer to this one than to that around the
    /// box, 0 to 1. Not measured by itself.
    probability: f32,
    /// Minimum contrast of a blob, 0 to 1. Not measured by itself.
    min_contrast: f32,
    /// A box with less contrast than this share of the blob's has slipped off, 0 to 1. Not measured by
    /// itself.
    slipped_share: f32,
    /// Consecutive checks after which the box is corrected. Not measured by itself.
    checks: u32,
}

impl Default for SlippedBoxSettings {
    fn default() -> Self {
        Self {
            interval: 8,
            steps: 5,
            min_half_px: 6.0,
            reach: 1.35,
            probability: 0.95,
            min_contrast: 0.4,
            slipped_share: 0.6,
            checks: 4,
        }
    }
}

/// The check, with its counters.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SlippedBoxCheck {
    settings: SlippedBoxSettings,
    /// Number of frames in which the target was found.
    frames: u32,
    /// Consecutive checks in which the colour lay elsewhere than the box.
    misfits: u32,
}

impl SlippedBoxCheck {
    /// The blob onto which the box has to move; `None` where the box has not slipped.
    pub(super) fn find(&mut self, crop: &Crop, geometry: &TargetGeometry) -> Option<Silhouette> {
        self.frames = self.frames.wrapping_add(1);
        if !self.frames.is_multiple_of(self.settings.interval) {
            return None;
        }
        let contrast = crop.contrast(geometry.centre, geometry.half_axes(), geometry.axis);
        let slipped_share = self.settings.slipped_share;
        let has_slipped =
            |(_, blob_contrast): &(Silhouette, f32)| contrast.difference() < slipped_share * blob_contrast;
        let Some((seen, _)) = self.find_blob(crop, geometry, contrast.ring).filter(has_slipped) else {
            self.misfits = 0;
            return None;
        };
        self.misfits += 1;
        if self.misfits < self.settings.checks {
            return None;
        }
        self.misfits = 0;
        Some(seen)
    }

    /// The blob of the target's colour that starts in the target's box, and its contrast. `ring` is the
    /// target probability around the box. `None` where the blob has too little contrast.
    fn find_blob(&self, crop: &Crop, geometry: &TargetGeometry, ring: f32) -> Option<(Silhouette, f32)> {
        let settings = &self.settings;
        let (along, across) = geometry.half_axes();
        let at_least = |half: f32| half.max(settings.min_half_px);
        let mut centre = geometry.centre;
        let mut half = (at_least(2.0 * along), at_least(2.0 * along.max(across)));
        let mut angle = geometry.axis;
        let contrast = ColourContrast { inside: settings.probability, ring };
        let mut found: Option<Silhouette> = None;
        for _ in 0..settings.steps {
            let seen = Silhouette::measure(crop, centre, half, angle, contrast)?;
            centre = seen.centroid;
            half = (at_least(0.5 * settings.reach * seen.major), at_least(0.5 * settings.reach * seen.minor));
            angle = seen.axis;
            found = Some(seen);
        }
        let seen = found?;
        let own = (0.5 * seen.major, 0.5 * seen.minor);
        let contrast = crop.contrast(seen.centroid, own, seen.axis).difference();
        (contrast >= settings.min_contrast).then_some((seen, contrast))
    }
}
