//! One mark: where it is on the water, and how well that is known.

use barrelman_vocab::{MarkKind, PixelPoint, Timestamp, VesselProfile, WaterFix, WaterPoint};

use super::drift::Drift;
use crate::vessel::frame_view::FrameView;

/// Growth of the standard deviation of a person's place, m/s, beside that of the drift: swimming, and what is
/// left of the sway.
const PERSON_DRIFT_M_PER_S: f64 = 0.1;
/// The standard deviation grows no further than this, metres.
const MAX_STD_DEV_M: f64 = 5.0;
/// Radius of a forbidden area, metres.
pub const FORBIDDEN_M: f64 = 5.0;

/// A mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Number of the mark, from 1; no number is used twice.
    pub id: u32,
    /// What is there.
    pub kind: MarkKind,
    /// Line of sight: a unit vector (right, ahead, up) in the frame of reference that does not turn with the
    /// camera.
    pub direction: [f64; 3],
    /// Where it is on the water; `None`: height or tilt were not known since it was set.
    pub water: Option<WaterFix>,
    /// Whether a tilt of the camera had been reported when the mark was set or moved. Without one, the
    /// direction is that of the tilt in the profile.
    pub(super) has_tilt: bool,
    /// Time of capture of its video frame.
    pub marked: Timestamp,
    /// How the marked person drifts; `None`: no person, or no place on the water.
    pub drift: Option<Drift>,
}

impl Mark {
    /// Standard deviation of the place at `now`, metres, which grows for a person alone; `None` without a
    /// place on the water.
    pub fn std_dev_m(&self, now: Timestamp) -> Option<f64> {
        let drift =
            self.drift.map_or(0.0, |drift| libm::hypot(PERSON_DRIFT_M_PER_S, drift.std_dev_m_per_s()));
        let grown = drift * now.since(self.marked).as_secs_f64();
        let fixed = self.water?.covariance.max_std_dev_m();
        Some(libm::sqrt(fixed * fixed + grown * grown).min(MAX_STD_DEV_M))
    }

    /// Velocity over the water frame along x and y, m/s.
    pub fn velocity_m_per_s(&self) -> (f64, f64) {
        self.drift.map_or((0.0, 0.0), |drift| drift.velocity_m_per_s)
    }

    /// The point on the water at `now`.
    pub fn point(&self, now: Timestamp) -> Option<WaterPoint> {
        let WaterPoint { x, y } = self.water?.point;
        let (vx, vy) = self.velocity_m_per_s();
        let since_s = now.since(self.marked).as_secs_f64();
        Some(WaterPoint { x: x + vx * since_s, y: y + vy * since_s })
    }

    /// The pixel of the mark at `now`; `None`: behind the camera.
    pub fn pixel(&self, frame_view: &FrameView, now: Timestamp) -> Option<PixelPoint> {
        match self.point(now).filter(|_| frame_view.sees_water) {
            Some(point) => frame_view.view.pixel_of_water(point),
            None => frame_view.view.pixel_of(self.direction),
        }
    }

    /// Whether the boat's way leads to the mark: it is the destination, or a way-point.
    pub(super) fn is_on_route(&self, destination: Option<u32>) -> bool {
        destination == Some(self.id) || self.kind == MarkKind::WayPoint
    }

    /// Radius of the circle around the mark that the boat keeps out of, metres: 0 for a mark without a
    /// circle. The uncertainty is not in it.
    pub const fn radius_m(&self, profile: &VesselProfile, is_destination: bool) -> f64 {
        match self.kind {
            MarkKind::Person if is_destination => profile.stand_off_m,
            MarkKind::Person => profile.keep_out_m,
            MarkKind::Forbidden => FORBIDDEN_M,
            MarkKind::Place | MarkKind::WayPoint | MarkKind::Home => 0.0,
        }
    }
}
