//! What the placing of objects must know of a clip: where the camera looks, and where the boat goes.

use super::object::SceneObject;
use super::outline::Outline;
use super::script::{FRAMES_PER_SECOND, TargetPaint};
use super::trajectory::Trajectory;
use super::view::PlanePoint;

/// Frames from one check of a position to the next.
pub(super) const CHECK_EVERY: usize = 3;
/// An object this near to the border counts as in view, as a share of the picture's width: as far as a pan
/// takes it between two checks.
const BORDER_SHARE: f64 = 0.07;
/// Largest number of distractors in view at the same time.
pub(super) const MAX_DISTRACTORS: usize = 2;
/// Least distance of an object from the boat, in shares of the sum of their reaches.
const CLEARANCE_SHARE: f64 = 1.15;

/// What placing must know.
pub(super) struct PlacementContext<'a> {
    pub(super) trajectory: &'a Trajectory,
    pub(super) frames: usize,
    pub(super) outline: &'a Outline,
    pub(super) paint: TargetPaint,
    /// Picture width over that of the reference picture.
    pub(super) relative: f64,
}

impl PlacementContext<'_> {
    pub(super) fn checks(&self) -> impl Iterator<Item = usize> {
        (0..self.frames).step_by(CHECK_EVERY)
    }

    /// For each checked frame, whether an object may be in view; `None` if it comes too near to the boat.
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

    /// The point of the plane that a frame shows at a share of its width and height.
    pub(super) fn plane_point_at(&self, frame: usize, share: (f64, f64)) -> PlanePoint {
        let view = self.trajectory.pose(frame as i64).view;
        view.plane(share.0 * f64::from(view.size.width), share.1 * f64::from(view.size.height))
    }
}
