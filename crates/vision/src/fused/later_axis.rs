//! The stage that measures the axis of a target whose selection showed none: the contrast of its colours was
//! too low, it lay end on, or the box was too wide.
//!
//! The axis is reported only; the box stays upright and follows the network's edges. Later silhouettes must
//! agree for a while, since a single one may be that of the wake.
//!
//! Input: the crop and the target's box. Output: one end of the axis, which keeps its end, and both sides.

use super::extent::upright_box_of;
use super::ratio::is_within;
use super::seen_axis::SeenAxis;
use super::selection::ellipse_around_box;
use super::shape_following::axis_difference;
use super::target::Target;
use super::time_constant::rate_in;
use crate::crop::Crop;
use crate::silhouette::Silhouette;

/// Settings of the later axis. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
struct LaterAxisSettings {
    /// Minimum contrast of a silhouette, 0 to 1.
    min_contrast: f32,
    /// Maximum ratio of minor to major axis of a silhouette that gives the axis, 0 to 1.
    max_roundness: f32,
    /// Minimum share of the ellipse of its axes that a silhouette of a single object fills, 0 to 1.
    min_fill: f32,
    /// Maximum ratio of the sides of the silhouette's upright box to those of the target's.
    max_misfit: f32,
    /// Maximum difference of silhouettes that agree, radians.
    max_difference: f32,
    /// How long silhouettes must have agreed, seconds, ...
    known_s: f32,
    /// ... and how long the axis outlasts the last one, seconds.
    kept_s: f32,
    /// Time constant with which axis and sides follow the silhouette's, seconds.
    time_s: f64,
}

impl Default for LaterAxisSettings {
    fn default() -> Self {
        Self {
            min_contrast: 0.3,
            max_roundness: 0.55,
            min_fill: 0.7,
            max_misfit: 1.5,
            max_difference: 0.3,
            known_s: 0.5,
            kept_s: 1.0,
            time_s: 0.15,
        }
    }
}

/// The axis by silhouettes after the selection.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LaterAxis {
    settings: LaterAxisSettings,
    seen: Option<SeenAxis>,
    /// How long the silhouettes have agreed, less how long they have not, seconds.
    agreed_s: f32,
    is_known: bool,
}

impl LaterAxis {
    /// The axis, once the silhouettes have agreed.
    pub(super) fn seen(&self) -> Option<SeenAxis> {
        self.seen.filter(|_| self.is_known)
    }

    /// Measures the silhouette, `seconds` after the last frame, since when the target has turned by `turn`,
    /// radians clockwise. Returns whether the axis is a new one, with other ends.
    pub(super) fn follow(&mut self, crop: &Crop, target: &Target, turn: f32, seconds: f32) -> bool {
        let settings = self.settings;
        if target.reference.is_some() || target.geometry.touches_border() {
            return false;
        }
        let expected = self.seen.map(|last| SeenAxis { angle: last.angle + turn, ..last });
        let measured = self.measure(crop, target);
        let agrees = |last: &SeenAxis, seen: &Silhouette| {
            axis_difference(seen.axis, last.angle).abs() <= settings.max_difference
        };
        match (expected, measured) {
            (Some(last), Some(seen)) if agrees(&last, &seen) => {
                let rate = rate_in(f64::from(seconds), settings.time_s);
                let side = |known: f32, measured: f32| known + rate * (measured - known);
                self.seen = Some(SeenAxis {
                    angle: last.angle + rate * axis_difference(seen.axis, last.angle),
                    sides: (side(last.sides.0, seen.major), side(last.sides.1, seen.minor)),
                });
                self.agreed_s = (self.agreed_s + seconds).min(settings.kept_s);
            }
            _ => {
                self.seen = expected;
                self.agreed_s -= seconds;
            }
        }
        if self.agreed_s <= 0.0 {
            self.agreed_s = 0.0;
            self.is_known = false;
            self.seen = measured.map(|seen| SeenAxis { angle: seen.axis, sides: (seen.major, seen.minor) });
        }
        let becomes_known = !self.is_known && self.agreed_s >= settings.known_s;
        self.is_known |= becomes_known;
        becomes_known
    }

    /// A silhouette that gives the axis.
    fn measure(&self, crop: &Crop, target: &Target) -> Option<Silhouette> {
        let (settings, geometry) = (&self.settings, &target.geometry);
        let (width, height) = geometry.upright_box();
        let half = (0.5 * width, 0.5 * height);
        let contrast = crop.contrast(geometry.centre, half, 0.0);
        let seen = Silhouette::measure(crop, geometry.centre, ellipse_around_box(half), 0.0, contrast)?;
        let own = crop.contrast(seen.centroid, seen.half_axes(), seen.axis);
        let (wide, high) = upright_box_of(seen.major, seen.minor, seen.axis);
        let fits = |seen: f32, known: f32| is_within(seen / known, settings.max_misfit);
        (own.difference() >= settings.min_contrast
            && seen.roundness() <= settings.max_roundness
            && seen.fill() >= settings.min_fill
            && fits(wide, width)
            && fits(high, height))
        .then_some(seen)
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PixelBox;

    use super::super::extent::Extent;
    use super::super::follower::Follower;
    use super::super::test_target::{red_on_blue, selected};
    use super::*;

    const FRAME_S: f32 = 1.0 / 30.0;
    /// An object of 40 x 12 pixels around the middle of the picture fits into this box at each angle.
    const AROUND: PixelBox = PixelBox { u: 102.0, v: 62.0, w: 36.0, h: 36.0 };

    /// The crop of an object at this angle, degrees clockwise, and the target without a silhouette.
    fn object_at(angle_deg: f32) -> Follower {
        let (sin, cos) = (libm::sinf(angle_deg.to_radians()), libm::cosf(angle_deg.to_radians()));
        let is_red = |column: usize, row: usize| {
            let (u, v) = (column as f32 - 120.0, row as f32 - 80.0);
            (u * cos + v * sin).abs() < 20.0 && (v * cos - u * sin).abs() < 6.0
        };
        let (mut follower, _) = selected(red_on_blue((240, 160), is_red), AROUND);
        follower.target.reference = None;
        let (width, height) = upright_box_of(40.0, 12.0, angle_deg.to_radians());
        follower.target.geometry.extent = Extent::Box { width, height };
        follower.target.geometry.centre = (120.0, 80.0);
        follower.target.geometry.scale = 1.0;
        follower
    }

    fn follow(axis: &mut LaterAxis, object: &Follower, turn: f32, frames: u32) -> u32 {
        let crop = &object.detector.observer.crop;
        (0..frames).map(|_| u32::from(axis.follow(crop, &object.target, turn, FRAME_S))).sum()
    }

    #[test]
    fn silhouettes_that_agree_tell_the_axis_which_outlasts_them_for_a_while() {
        let mut axis = LaterAxis::default();
        let object = object_at(30.0);
        assert_eq!((follow(&mut axis, &object, 0.0, 12), axis.seen()), (0, None), "not long enough");
        assert_eq!(follow(&mut axis, &object, 0.0, 20), 1, "it becomes known once");
        let angle_deg = |axis: &LaterAxis| axis.seen().map(|seen| seen.angle.to_degrees());
        assert!(angle_deg(&axis).is_some_and(|angle| (angle - 30.0).abs() < 3.0), "{axis:?}");
        let even = selected(red_on_blue((240, 160), |_, _| false), AROUND).0;
        assert_eq!(follow(&mut axis, &even, 0.0, 15), 0);
        assert!(axis.seen().is_some());
        follow(&mut axis, &even, 0.0, 30);
        assert_eq!(axis.seen(), None);
    }

    #[test]
    fn an_axis_keeps_its_end_while_the_object_turns_around() {
        let mut axis = LaterAxis::default();
        follow(&mut axis, &object_at(0.0), 0.0, 30);
        for step in 1..=36 {
            follow(&mut axis, &object_at(5.0 * step as f32), 5_f32.to_radians(), 1);
            follow(&mut axis, &object_at(5.0 * step as f32), 0.0, 5);
        }
        assert!(axis.seen().is_some_and(|seen| (seen.angle.to_degrees() - 180.0).abs() < 5.0), "{axis:?}");
    }

    #[test]
    fn silhouettes_that_contradict_each_other_and_round_ones_tell_nothing() {
        let mut axis = LaterAxis::default();
        let objects = [object_at(20.0), object_at(80.0)];
        for frame in 0..60 {
            assert_eq!(follow(&mut axis, &objects[frame % 2], 0.0, 1), 0);
        }
        let round = |column: usize, row: usize| libm::hypotf(column as f32 - 120.0, row as f32 - 80.0) < 14.0;
        let mut object = selected(red_on_blue((240, 160), round), AROUND).0;
        object.target.reference = None;
        assert_eq!(follow(&mut axis, &object, 0.0, 60), 0);
        assert_eq!(axis.seen(), None);
    }
}
