//! The followed boat as a detection in the picture.

use crate::console::api::{Snapshot, Track};
use crate::convert::frames::Frames;
use crate::messages::{
    BoundingBox2D, Detection2D, Detection2DArray, ObjectHypothesis, ObjectHypothesisWithPose, Point2D,
    Pose2D, PoseWithCovariance, Time,
};

/// The class of the followed object, and the name of its track.
const BOAT: &str = "boat";

/// The box of a boat with the confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seen {
    bounds: [f64; 4],
    confidence: f64,
}

/// What is seen in a video frame: the content of one message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Time of capture of the video frame, nanoseconds since the program's start.
    pub captured_ns: u64,
    /// `None`: the boat is not seen.
    boat: Option<Seen>,
}

impl Sighting {
    /// The sighting of a state; `None` before the first video frame.
    pub fn of(snapshot: &Snapshot) -> Option<Self> {
        let boat = seen(&snapshot.track);
        let captured_ns =
            snapshot.track.captured_ns.filter(|_| boat.is_some()).or(snapshot.video.captured_ns)?;
        Some(Self { captured_ns, boat })
    }

    /// The message.
    pub fn message(&self, stamp: Time, frames: &Frames) -> Detection2DArray {
        let header = frames.picture(stamp);
        let detections = self.boat.iter().map(|boat| Detection2D {
            header: header.clone(),
            results: vec![ObjectHypothesisWithPose {
                hypothesis: ObjectHypothesis { class_id: BOAT.to_owned(), score: boat.confidence },
                pose: PoseWithCovariance::default(),
            }],
            bbox: bounding_box(boat.bounds),
            id: BOAT.to_owned(),
        });
        Detection2DArray { detections: detections.collect(), header }
    }
}

/// The boat of a confirmed track. An unconfirmed selection is no detection, nor is what a detector doubts.
fn seen(track: &Track) -> Option<Seen> {
    let (bounds, confidence) = (track.bounds?, track.confidence?);
    (!track.confirming && !track.doubted).then_some(Seen { bounds, confidence })
}

fn bounding_box([left, top, width, height]: [f64; 4]) -> BoundingBox2D {
    let position = Point2D { x: left + width / 2.0, y: top + height / 2.0 };
    BoundingBox2D { center: Pose2D { position, theta: 0.0 }, size_x: width, size_y: height }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_states::{FRAME_NS, snapshot, tracking};

    /// A track has this box (centre and size) with this score in its message, or none.
    #[track_caller]
    fn check(track: Track, expected: Option<([f64; 4], f64)>) {
        let sighting = Sighting::of(&snapshot(track)).unwrap();
        assert_eq!(sighting.captured_ns, FRAME_NS);
        let frames = Frames { node: "a/b".to_owned() };
        let message = sighting.message(Time { sec: 1, nanosec: 2 }, &frames);
        assert_eq!(message.header.frame_id, "a/b/camera_optical");
        let found = message.detections.first().map(|found| {
            assert_eq!(found.header, message.header);
            assert_eq!(found.results[0].hypothesis.class_id, "boat");
            let BoundingBox2D { center, size_x, size_y } = found.bbox;
            ([center.position.x, center.position.y, size_x, size_y], found.results[0].hypothesis.score)
        });
        assert_eq!(found, expected);
    }

    #[test]
    fn a_followed_boat_is_a_detection_and_a_lost_one_is_none() {
        let boat = tracking([10.0, 20.0, 8.0, 6.0], 0.75);
        let seen = Some(([14.0, 23.0, 8.0, 6.0], 0.75));
        check(boat.clone(), seen);
        check(Track { state: "coasting".to_owned(), ..boat.clone() }, seen);
        check(Track { confirming: true, ..boat.clone() }, None);
        check(Track { doubted: true, ..boat.clone() }, None);
        let lost = Track { state: "lost".to_owned(), bounds: None, captured_ns: None, ..boat.clone() };
        check(lost, None);
        check(Track { bounds: None, confidence: None, captured_ns: None, ..boat }, None);
    }

    #[test]
    fn nothing_is_said_before_the_first_video_frame() {
        let mut state = snapshot(tracking([0.0; 4], 0.5));
        (state.track.captured_ns, state.video.captured_ns) = (None, None);
        assert_eq!(Sighting::of(&state), None);
    }
}
