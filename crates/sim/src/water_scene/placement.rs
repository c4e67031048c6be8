//! What the placing of objects must know of a clip: where the camera looks, and where the boat goes.

use super::object::SceneObject;
use super::outline::Outline;
use super::script::{FRAMES_PER_SECOND, TargetPaint};
use super::trajectory::Trajectory;
use super::view::PlanePoint;

/// Frames from one check of a place to the next; a thing counts as in view a little beyond the border.
pub(super) const CHECK_EVERY: usize = 3;
/// That much beyond, as a share of the picture's width: as far as a pan takes a thing between two checks.
const BORDER_SHARE: f64 = 0.07;
/// Distractors in view at the same time, at most.
pub(super) const MAX_DISTRACTORS: usize = 2;
/// A thing comes no nearer to the boat than this, in shares of both their reaches.
const CLEARANCE_SHARE: f64 = 1.15;

/// What placing must know.
pub(super) struct PlacementContext<'a> {
    pub(super) trajectory: &'a Trajectory,
    pub(super) frames: usize,
    pub(super) outline: &'a Outline,
    pub(super) paint: TargetPaint,
    /// Picture width over the reference picture's.
    pub(super) relative: f64,
}

impl PlacementContext<'_> {
    pub(super) fn checks(&self) -> impl Iterator<Item = usize> {
        (0..self.frames).step_by(CHECK_EVERY)
    }

    /// The frames (of those checked) in which a thing may be in view; none if it comes too near to the boat.
    pub(super) fn appearances(&self, object: &SceneObject) -> Option<Vec<bool>> {
        let reach = object.body.outline.reach();
        let clear = CLEARANCE_SHARE * (reach + self.outline.reach());
        self.checks()
            .map(|frame| {
                let pose = self.trajectory.pose(frame as i64);
                let at = object.pose_at(frame as f64 / f64::from(FRAMES_PER_SECOND)).at;
                let middle = pose.view.picture(at);
                let (width, height) = (f64::from(pose.view.size.width), f64::from(pose.view.size.height));
                let beyond = reach * pose.view.zoom + BORDER_SHARE * width;
                let seen = middle.u > -beyond
                    && middle.u < width + beyond
                    && middle.v > -beyond
                    && middle.v < height + beyond;
                (at.distance(pose.boat) > clear).then_some(seen)
            })
            .collect()
    }

    /// The place of the plane that a frame shows at a share of its width and height.
    pub(super) fn plane_point_at(&self, frame: usize, share: (f64, f64)) -> PlanePoint {
        let view = self.trajectory.pose(frame as i64).view;
        view.plane(share.0 * f64::from(view.size.width), share.1 * f64::from(view.size.height))
    }
}
