//! Where the bow points: the axis of the hull, told from its opposite by the way that the boat went.
//!
//! The axis of a silhouette has two ends. Which of them is the bow is taken from the path over water of the last
//! [`MEMORY_S`] seconds, with the camera's own motion taken out, simplified by Douglas and Peucker's method (1973) to
//! a few straight legs (by time and not by frames, so that it holds at any frame rate). Where the last leg is long
//! enough, its direction votes for one of the two ends; the votes add up and are bounded. A boat that stops keeps
//! its bow; one that was never seen under way has none.

use std::collections::VecDeque;

/// How far back the path goes, seconds.
const MEMORY_S: f64 = 2.0;
/// Least time between two points of the path, seconds: enough for 60 frames per second.
const EVERY_S: f64 = 0.03;
/// Most points kept.
const POINTS: usize = 72;
/// Points of the path nearer to a leg than this share of the boat's length belong to it.
const TOLERANCE_LENGTHS: f64 = 0.12;
/// A leg shorter than this share of the boat's length says nothing.
const LEAST_LEG_LENGTHS: f64 = 0.25;
/// Votes per second of a leg right along the axis.
const VOTES_PER_S: f64 = 6.0;
/// Votes are bounded by this, so that a boat that turns about is believed within a second or two.
const MOST_VOTES: f64 = 6.0;
/// From this many votes on the bow is known.
const KNOWN_VOTES: f64 = 2.0;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    at_s: f64,
    u: f64,
    v: f64,
}

/// The path, and the votes.
#[derive(Debug, Clone)]
pub(crate) struct Heading {
    path: VecDeque<Point>,
    /// Where the boat is on the path, in pixels over resting water.
    here: (f64, f64),
    /// Positive for the end of the axis that it is given, negative for the other.
    votes: f64,
}

impl Default for Heading {
    fn default() -> Self {
        Self { path: VecDeque::with_capacity(POINTS + 1), here: (0.0, 0.0), votes: 0.0 }
    }
}

impl Heading {
    /// The motion over water is not known for a while: the path begins anew, the bow stays.
    pub(crate) fn interrupt(&mut self) {
        self.path.clear();
    }

    /// Forgets the path and the votes.
    pub(crate) fn forget(&mut self) {
        self.path.clear();
        self.votes = 0.0;
    }

    /// Takes in that the boat, `length` pixels long, moved by `(du, dv)` pixels over resting water; `axis` is one end
    /// of its axis (radians clockwise from image right), the same end as in the frame before.
    pub(crate) fn moved(&mut self, at_s: f64, seconds: f64, (du, dv): (f64, f64), axis: f64, length: f64) {
        self.here = (self.here.0 + du, self.here.1 + dv);
        if self.path.back().is_none_or(|last| at_s - last.at_s >= EVERY_S) {
            if self.path.len() >= POINTS {
                self.path.pop_front();
            }
            self.path.push_back(Point { at_s, u: self.here.0, v: self.here.1 });
        }
        while self.path.front().is_some_and(|first| at_s - first.at_s > MEMORY_S) {
            self.path.pop_front();
        }
        let Some((leg_u, leg_v)) = self.last_leg(TOLERANCE_LENGTHS * length) else { return };
        let long = libm::hypot(leg_u, leg_v);
        if long < LEAST_LEG_LENGTHS * length {
            return;
        }
        let along = (leg_u * libm::cos(axis) + leg_v * libm::sin(axis)) / long;
        self.votes = (self.votes + VOTES_PER_S * seconds * along).clamp(-MOST_VOTES, MOST_VOTES);
    }

    /// Whether the bow is at the given end of the axis (true) or at the other (false); none while it is not known.
    pub(crate) fn bow(&self) -> Option<bool> {
        (self.votes.abs() >= KNOWN_VOTES).then_some(self.votes > 0.0)
    }

    /// How sure it is that the bow is at the given end of the axis: 1 where it is known to be there, -1 where it is known
    /// to be at the other end, in between on the way.
    pub(crate) fn certainty(&self) -> f64 {
        (self.votes / KNOWN_VOTES).clamp(-1.0, 1.0)
    }

    /// From the last corner of the simplified path to its end.
    fn last_leg(&self, tolerance: f64) -> Option<(f64, f64)> {
        let end = *self.path.back()?;
        let mut start = 0;
        let last = self.path.len() - 1;
        // Only the last leg is wanted: as long as a point lies off the line from the start, the path is cut at the
        // farthest one and the rest behind it looked at.
        while start + 1 < last {
            let from = self.path[start];
            let (du, dv) = (end.u - from.u, end.v - from.v);
            let long = libm::hypot(du, dv).max(1.0e-9);
            let off = |p: &Point| ((p.u - from.u) * dv - (p.v - from.v) * du).abs() / long;
            let (mut farthest, mut distance) = (start, 0.0);
            for index in start + 1..last {
                let here = off(&self.path[index]);
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

    /// A boat and the clock.
    #[derive(Default)]
    struct Boat {
        heading: Heading,
        now_s: f64,
    }

    impl Boat {
        /// Goes on for that long at that many lengths per second in a direction (degrees clockwise from image right),
        /// its axis at zero.
        fn goes(&mut self, seconds: f64, lengths_per_s: f64, direction_deg: f64) -> Option<bool> {
            for _ in 0..(seconds / FRAME_S) as usize {
                self.now_s += FRAME_S;
                let pixels = lengths_per_s * LENGTH_PX * FRAME_S;
                let direction = direction_deg.to_radians();
                let moved = (pixels * libm::cos(direction), pixels * libm::sin(direction));
                self.heading.moved(self.now_s, FRAME_S, moved, 0.0, LENGTH_PX);
            }
            self.heading.bow()
        }
    }

    #[test]
    fn the_bow_is_not_known_at_first_nor_of_a_boat_that_stays() {
        assert_eq!((Heading::default().bow(), Heading::default().certainty()), (None, 0.0));
        assert_eq!(Boat::default().goes(5.0, 0.0, 0.0), None);
        // Less than a quarter of its length in the two seconds that are remembered.
        assert_eq!(Boat::default().goes(5.0, 0.1, 0.0), None);
    }

    #[test]
    fn the_bow_is_known_after_a_straight_run() {
        for (direction_deg, expected) in
            [(0.0, Some(true)), (30.0, Some(true)), (180.0, Some(false)), (150.0, Some(false)), (90.0, None)]
        {
            assert_eq!(Boat::default().goes(1.5, 1.0, direction_deg), expected, "{direction_deg}");
        }
    }

    #[test]
    fn certainty_grows_to_the_end_that_the_bow_is_at() {
        for (direction_deg, end) in [(0.0, 1.0), (180.0, -1.0)] {
            let mut boat = Boat::default();
            let mut before = 0.0;
            while boat.goes(0.1, 1.0, direction_deg).is_none() {
                let certainty = boat.heading.certainty() * end;
                assert!((before..1.0).contains(&certainty), "{direction_deg}: {before}, {certainty}");
                before = certainty;
            }
            assert_eq!(boat.heading.certainty(), end);
        }
    }

    #[test]
    fn a_boat_that_goes_the_other_way_for_long_is_believed() {
        let mut boat = Boat::default();
        assert_eq!(boat.goes(3.0, 1.0, 0.0), Some(true));
        assert_eq!(boat.goes(0.3, 1.0, 180.0), Some(true));
        assert_eq!(boat.goes(2.5, 1.0, 180.0), Some(false));
    }

    #[test]
    fn a_boat_that_stops_keeps_its_bow() {
        let mut boat = Boat::default();
        boat.goes(2.0, 1.0, 0.0);
        assert_eq!(boat.goes(20.0, 0.0, 0.0), Some(true));
        boat.heading.interrupt();
        assert_eq!(boat.goes(5.0, 0.0, 0.0), Some(true));
        boat.heading.forget();
        assert_eq!(boat.goes(5.0, 0.0, 0.0), None);
    }

    #[test]
    fn the_bow_comes_as_soon_at_any_frame_rate() {
        for frame_s in [1.0 / 120.0, 1.0 / 60.0, 1.0 / 10.0] {
            let mut heading = Heading::default();
            let mut now_s = 0.0;
            while heading.bow().is_none() {
                now_s += frame_s;
                heading.moved(now_s, frame_s, (LENGTH_PX * frame_s, 0.0), 0.0, LENGTH_PX);
                assert!(now_s < 2.0, "{frame_s}");
            }
            // A quarter of its length and two votes at six a second: 0.25 + 0.33 s, and a frame or two.
            assert!((now_s - 0.6).abs() < 0.25, "{now_s} s at {frame_s} s a frame");
        }
    }

    #[test]
    fn sway_about_one_place_tells_nothing() {
        let mut heading = Heading::default();
        for step in 0..300 {
            let phase = 0.3 * f64::from(step);
            let moved = (1.5 * libm::cos(phase), 1.5 * libm::sin(phase));
            heading.moved(f64::from(step) * FRAME_S, FRAME_S, moved, 0.0, LENGTH_PX);
        }
        assert_eq!(heading.bow(), None);
    }
}
