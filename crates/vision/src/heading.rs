//! Heading: which end of the hull's axis is the bow, estimated from the boat's path.
//!
//! A silhouette's axis has two ends. The path over water of the last [`PATH_DURATION_S`] seconds, without the
//! camera's motion, is simplified by the method of Douglas and Peucker (1973) to a few straight legs. The
//! path is kept by time, not by frames, so that the result does not depend on the frame rate. If the last leg
//! is long enough, its direction votes for one end of the axis; the votes are summed and bounded. A boat that
//! stops keeps its heading; a boat that was never under way has none.
//!
//! The path of a boat that is known to go astern, or to drift, does not vote.
//!
//! Bow and stern do not change places. Where the camera's motion is only measured in the picture, which on
//! water may take the camera's motion for the boat's, votes against a bow that was known make it unknown, and
//! not the other end the bow.

use std::collections::VecDeque;

/// Duration of the path, seconds.
const PATH_DURATION_S: f64 = 2.0;
/// Minimum time between two points of the path, seconds: sufficient for 60 frames per second.
const MIN_POINT_INTERVAL_S: f64 = 0.03;
/// Maximum number of points.
const MAX_POINTS: usize = 72;
/// Tolerance of the simplification, in lengths of the boat.
const TOLERANCE_LENGTHS: f64 = 0.12;
/// Minimum length of a leg that votes, in lengths of the boat.
const MIN_LEG_LENGTHS: f64 = 0.25;
/// Votes per second of a leg parallel to the axis.
const VOTES_PER_S: f64 = 6.0;
/// Bound on the votes, so that a boat that reverses its direction is recognised within a second or two.
const MAX_VOTES: f64 = 6.0;
/// Minimum votes for a known bow.
const MIN_VOTES_FOR_BOW: f64 = 2.0;

#[derive(Debug, Clone, Copy, PartialEq)]
struct PathPoint {
    at_s: f64,
    u: f64,
    v: f64,
}

/// Estimates the bow from the path.
#[derive(Debug)]
pub(crate) struct HeadingEstimator {
    path: VecDeque<PathPoint>,
    /// Present position on the path, pixels over stationary water.
    position: (f64, f64),
    /// Positive for the given end of the axis, negative for the other.
    votes: f64,
    /// Whether the bow that was known last is at the given end of the axis.
    known: Option<bool>,
    /// Whether the boat may go bow first.
    is_bow_first: bool,
}

/// How the camera's motion is known, which is not in the boat's motion over the water.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CameraMotionSource {
    /// The vehicle tells it, or confirms what was measured.
    Told,
    /// It is measured in the picture alone.
    Measured,
}

impl Default for HeadingEstimator {
    fn default() -> Self {
        Self {
            path: VecDeque::with_capacity(MAX_POINTS + 1),
            position: (0.0, 0.0),
            votes: 0.0,
            known: None,
            is_bow_first: true,
        }
    }
}

impl HeadingEstimator {
    /// Starts the path anew, because the motion over water is unknown for a while. The votes stay.
    pub(crate) fn clear_path(&mut self) {
        self.path.clear();
    }

    /// Whether the boat may go bow first from now on.
    pub(crate) const fn set_bow_first(&mut self, may_be: bool) {
        self.is_bow_first = may_be;
    }

    /// Discards path and votes.
    pub(crate) fn reset(&mut self) {
        self.path.clear();
        (self.votes, self.known) = (0.0, None);
    }

    /// Adds the motion since the last frame: `(du, dv)` pixels over stationary water in `seconds`, ending at
    /// `at_s`. `axis` is one end of the axis, radians clockwise from image right, the same end as in the last
    /// frame. `length` is the boat's length, pixels. `source`: how the camera's motion is known.
    pub(crate) fn add_motion(
        &mut self,
        at_s: f64,
        seconds: f64,
        (du, dv): (f64, f64),
        axis: f64,
        length: f64,
        source: CameraMotionSource,
    ) {
        if !self.is_bow_first {
            self.clear_path();
            return;
        }
        self.position = (self.position.0 + du, self.position.1 + dv);
        if self.path.back().is_none_or(|last| at_s - last.at_s >= MIN_POINT_INTERVAL_S) {
            if self.path.len() >= MAX_POINTS {
                self.path.pop_front();
            }
            self.path.push_back(PathPoint { at_s, u: self.position.0, v: self.position.1 });
        }
        while self.path.front().is_some_and(|first| at_s - first.at_s > PATH_DURATION_S) {
            self.path.pop_front();
        }
        let Some((leg_u, leg_v)) = self.last_leg(TOLERANCE_LENGTHS * length) else { return };
        let leg_length = libm::hypot(leg_u, leg_v);
        if leg_length < MIN_LEG_LENGTHS * length {
            return;
        }
        let along = (leg_u * libm::cos(axis) + leg_v * libm::sin(axis)) / leg_length;
        let (least, most) = match (source, self.known) {
            (CameraMotionSource::Measured, Some(true)) => (0.0, MAX_VOTES),
            (CameraMotionSource::Measured, Some(false)) => (-MAX_VOTES, 0.0),
            _ => (-MAX_VOTES, MAX_VOTES),
        };
        self.votes = (self.votes + VOTES_PER_S * seconds * along).clamp(least, most);
        self.known = self.is_bow_at_axis_end().or(self.known);
    }

    /// Whether the bow is at the given end of the axis (`true`) or at the other (`false`); `None` while it is
    /// unknown.
    pub(crate) fn is_bow_at_axis_end(&self) -> Option<bool> {
        (self.votes.abs() >= MIN_VOTES_FOR_BOW).then_some(self.votes > 0.0)
    }

    /// Certainty that the bow is at the given end of the axis: 1 if it is known to be there, -1 if at the
    /// other end.
    pub(crate) fn signed_certainty(&self) -> f64 {
        (self.votes / MIN_VOTES_FOR_BOW).clamp(-1.0, 1.0)
    }

    /// From the last corner of the simplified path to its end, pixels.
    fn last_leg(&self, tolerance: f64) -> Option<(f64, f64)> {
        let end = *self.path.back()?;
        let mut start = 0;
        let last = self.path.len() - 1;
        // Only the last leg is needed: while a point lies off the line from the start, the path is cut at the
        // farthest point and only the part behind it is examined.
        while start + 1 < last {
            let from = self.path[start];
            let (du, dv) = (end.u - from.u, end.v - from.v);
            let leg_length = libm::hypot(du, dv).max(1.0e-9);
            let distance_from_line =
                |p: &PathPoint| ((p.u - from.u) * dv - (p.v - from.v) * du).abs() / leg_length;
            let (mut farthest, mut distance) = (start, 0.0);
            for index in start + 1..last {
                let here = distance_from_line(&self.path[index]);
                if here > distance {
                    (farthest, distance) = (index, here);
                }
            }
            if distance <= tolerance {
                break;
            }
            start = farthest;
        }
        let from = self.path[start];
        Some((end.u - from.u, end.v - from.v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTH_PX: f64 = 60.0;
    const FRAME_S: f64 = 1.0 / 30.0;

    /// A boat and its time.
    struct Boat {
        heading: HeadingEstimator,
        now_s: f64,
        source: CameraMotionSource,
    }

    impl Default for Boat {
        fn default() -> Self {
            Self { heading: HeadingEstimator::default(), now_s: 0.0, source: CameraMotionSource::Told }
        }
    }

    impl Boat {
        /// Moves the boat at this speed in a direction (degrees clockwise from image right); its axis is at
        /// zero.
        fn move_for(&mut self, seconds: f64, lengths_per_s: f64, direction_deg: f64) -> Option<bool> {
            for _ in 0..(seconds / FRAME_S) as usize {
                self.now_s += FRAME_S;
                let pixels = lengths_per_s * LENGTH_PX * FRAME_S;
                let direction = direction_deg.to_radians();
                let moved = (pixels * libm::cos(direction), pixels * libm::sin(direction));
                self.heading.add_motion(self.now_s, FRAME_S, moved, 0.0, LENGTH_PX, self.source);
            }
            self.heading.is_bow_at_axis_end()
        }
    }

    #[test]
    fn the_bow_is_not_known_at_first_nor_of_a_boat_that_stays() {
        assert_eq!(
            (
                HeadingEstimator::default().is_bow_at_axis_end(),
                HeadingEstimator::default().signed_certainty()
            ),
            (None, 0.0)
        );
        assert_eq!(Boat::default().move_for(5.0, 0.0, 0.0), None);
        // Less than a quarter of the length within the duration of the path.
        assert_eq!(Boat::default().move_for(5.0, 0.1, 0.0), None);
    }

    #[test]
    fn the_bow_is_known_after_a_straight_run() {
        for (direction_deg, expected) in
            [(0.0, Some(true)), (30.0, Some(true)), (180.0, Some(false)), (150.0, Some(false)), (90.0, None)]
        {
            assert_eq!(Boat::default().move_for(1.5, 1.0, direction_deg), expected, "{direction_deg}");
        }
    }

    #[test]
    fn certainty_grows_to_the_end_that_the_bow_is_at() {
        for (direction_deg, end) in [(0.0, 1.0), (180.0, -1.0)] {
            let mut boat = Boat::default();
            let mut before = 0.0;
            while boat.move_for(0.1, 1.0, direction_deg).is_none() {
                let certainty = boat.heading.signed_certainty() * end;
                assert!((before..1.0).contains(&certainty), "{direction_deg}: {before}, {certainty}");
                before = certainty;
            }
            assert_eq!(boat.heading.signed_certainty(), end);
        }
    }

    #[test]
    fn a_boat_that_goes_the_other_way_for_long_is_believed() {
        let mut boat = Boat::default();
        assert_eq!(boat.move_for(3.0, 1.0, 0.0), Some(true));
        assert_eq!(boat.move_for(0.3, 1.0, 180.0), Some(true));
        assert_eq!(boat.move_for(2.5, 1.0, 180.0), Some(false));
    }

    #[test]
    fn a_camera_motion_that_is_only_measured_does_not_turn_the_bow_round() {
        let mut boat = Boat { source: CameraMotionSource::Measured, ..Boat::default() };
        assert_eq!(boat.move_for(2.0, 1.0, 0.0), Some(true));
        assert_eq!(boat.move_for(10.0, 1.0, 180.0), None);
        assert_eq!(boat.move_for(1.5, 1.0, 0.0), Some(true));
        boat.source = CameraMotionSource::Told;
        assert_eq!(boat.move_for(5.0, 1.0, 180.0), Some(false));
    }

    #[test]
    fn a_boat_that_stops_keeps_its_bow() {
        let mut boat = Boat::default();
        boat.move_for(2.0, 1.0, 0.0);
        assert_eq!(boat.move_for(20.0, 0.0, 0.0), Some(true));
        boat.heading.clear_path();
        assert_eq!(boat.move_for(5.0, 0.0, 0.0), Some(true));
        boat.heading.reset();
        assert_eq!(boat.move_for(5.0, 0.0, 0.0), None);
    }

    #[test]
    fn a_boat_that_cannot_go_bow_first_keeps_its_bow() {
        let mut boat = Boat::default();
        boat.heading.set_bow_first(false);
        assert_eq!(boat.move_for(5.0, 1.0, 180.0), None);
        boat.heading.set_bow_first(true);
        assert_eq!(boat.move_for(4.0, 1.0, 0.0), Some(true));
        boat.heading.set_bow_first(false);
        assert_eq!(boat.move_for(5.0, 1.0, 180.0), Some(true));
        // The path astern does not vote afterwards.
        boat.heading.set_bow_first(true);
        assert_eq!(boat.move_for(1.0, 1.0, 0.0), Some(true));
    }

    #[test]
    fn the_bow_comes_as_soon_at_any_frame_rate() {
        for frame_s in [1.0 / 120.0, 1.0 / 60.0, 1.0 / 10.0] {
            let mut heading = HeadingEstimator::default();
            let mut now_s = 0.0;
            while heading.is_bow_at_axis_end().is_none() {
                now_s += frame_s;
                heading.add_motion(
                    now_s,
                    frame_s,
                    (LENGTH_PX * frame_s, 0.0),
                    0.0,
                    LENGTH_PX,
                    CameraMotionSource::Told,
                );
                assert!(now_s < 2.0, "{frame_s}");
            }
            // A quarter of the length and two votes at six per second: 0.25 + 0.33 s, and a frame or two.
            assert!((now_s - 0.6).abs() < 0.25, "{now_s} s at {frame_s} s a frame");
        }
    }

    #[test]
    fn sway_about_one_place_tells_nothing() {
        let mut heading = HeadingEstimator::default();
        for step in 0..300 {
            let phase = 0.3 * f64::from(step);
            let moved = (1.5 * libm::cos(phase), 1.5 * libm::sin(phase));
            heading.add_motion(
                f64::from(step) * FRAME_S,
                FRAME_S,
                moved,
                0.0,
                LENGTH_PX,
                CameraMotionSource::Told,
            );
        }
        assert_eq!(heading.is_bow_at_axis_end(), None);
    }
}
