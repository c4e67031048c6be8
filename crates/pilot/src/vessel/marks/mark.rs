//! One mark: where it is on the water, and how well that is known.

use barrelman_vocab::{
    Localisation, MarkKind, PixelPoint, Timestamp, Track, VesselProfile, WaterFix, WaterPoint,
};

use super::drift::Drift;
use crate::vessel::frame_view::FrameView;

/// Growth of the standard deviation of a person's place, m/s, beside that of the drift: swimming, and what is
/// left of the sway.
const PERSON_DRIFT_M_PER_S: f64 = 0.1;
/// The standard deviation grows no further than this, metres.
const MAX_STD_DEV_M: f64 = 5.0;
/// Radius of a forbidden area, metres.
pub const FORBIDDEN_M: f64 = 5.0;

/// Time over which the places at which a tracker sees a person are averaged, and their scatter, seconds.
const AVERAGED_S: f64 = 1.0;
const SCATTER_S: f64 = 5.0;
/// Distance from its mark at which a person may be seen, beside three standard deviations, metres.
const NEAR_M: f64 = 1.0;
/// The same where the water is not known, and its growth with time: lines of sight, radians and rad/s.
const NEAR_RAD: f64 = 0.07;
const NEAR_RAD_PER_S: f64 = 0.02;
/// Largest such angle, radians.
const MAX_NEAR_RAD: f64 = 0.25;

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
    /// Time of capture of the video frame in which the mark was set, moved, or seen last.
    pub marked: Timestamp,
    /// How the marked person drifts; `None`: no person, or no place on the water.
    pub drift: Option<Drift>,
    /// Variance of each coordinate of the places at which a tracker saw the person, beside their mean, m².
    pub(super) scatter_m2: f64,
    /// What the tracker of the mark answers; `None`: the mark is not held.
    pub held: Option<Track>,
}

impl Mark {
    /// Whether a tracker sees the marked person, or saw it a moment ago.
    pub const fn is_held(&self) -> bool {
        matches!(self.held, Some(Track::Tracking(_) | Track::Coasting(_)))
    }

    /// Standard deviation of the place at `now`, metres, which grows for a person alone; `None` without a
    /// place on the water.
    pub fn std_dev_m(&self, now: Timestamp) -> Option<f64> {
        let drift =
            self.drift.map_or(0.0, |drift| libm::hypot(PERSON_DRIFT_M_PER_S, drift.std_dev_m_per_s()));
        let grown = drift * now.since(self.marked).as_secs_f64();
        let fixed = self.water?.covariance.max_std_dev_m();
        Some(libm::sqrt(fixed * fixed + grown * grown + self.scatter_m2).min(MAX_STD_DEV_M))
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

    /// Whether a person at a pixel of the view may be the marked one, by the place.
    pub(super) fn may_be_at(&self, pixel: PixelPoint, frame_view: &FrameView, now: Timestamp) -> bool {
        let unseen_s = now.since(self.marked).as_secs_f64();
        let seen = frame_view.fix(pixel);
        if let (Some(seen), Some(point), Some(std_dev_m)) = (seen, self.point(now), self.std_dev_m(now)) {
            let std_dev_m = libm::hypot(std_dev_m, seen.covariance.max_std_dev_m());
            let sway_m = frame_view.sway_m(seen.point, unseen_s);
            return point.distance_to(seen.point) <= NEAR_M + 3.0 * libm::hypot(std_dev_m, sway_m);
        }
        let Some([x, y, z]) = frame_view.view.direction_of(pixel) else { return false };
        let [mark_x, mark_y, mark_z] = self.direction;
        let near = (NEAR_RAD + NEAR_RAD_PER_S * unseen_s).min(MAX_NEAR_RAD);
        x * mark_x + y * mark_y + z * mark_z >= libm::cos(near)
    }

    /// The tracker sees the marked person.
    pub(super) fn hold_at(&mut self, seen: &Localisation, frame_view: &FrameView) {
        let pixel = seen.bounds.centre();
        let (Some(direction), fix) = (frame_view.view.direction_of(pixel), frame_view.fix(pixel)) else {
            return;
        };
        // A place that is known tells more than a line of sight close to the horizon.
        if fix.is_none() && self.water.is_some() && frame_view.sees_water {
            return;
        }
        match (&fix, &mut self.drift) {
            (Some(fix), Some(drift)) => _ = drift.see(fix, seen.captured),
            (Some(fix), drift) => *drift = Some(Drift::at_rest(fix, seen.captured)),
            (None, drift) => *drift = None,
        }
        self.direction = direction;
        // An old place is none: it is placed again when height and tilt are known.
        self.water = fix.map(|fix| self.averaged(fix, seen.captured));
        self.marked = seen.captured;
    }

    /// A measured place, averaged with those before; their scatter is measured, too. Waves lift a person, and
    /// the line of sight meets the water elsewhere then.
    fn averaged(&mut self, fix: WaterFix, captured: Timestamp) -> WaterFix {
        let Some(expected) = self.point(captured) else { return fix };
        let since_s = captured.since(self.marked).as_secs_f64();
        let share = |time_s: f64| 1.0 - libm::exp(-since_s / time_s);
        let (x, y) = expected.vector_to(fix.point);
        self.scatter_m2 += share(SCATTER_S) * (0.5 * (x * x + y * y) - self.scatter_m2);
        let taken = share(AVERAGED_S);
        WaterFix { point: WaterPoint { x: expected.x + taken * x, y: expected.y + taken * y }, ..fix }
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
