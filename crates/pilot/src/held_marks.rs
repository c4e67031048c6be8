//! The trackers of what is under the operator's marks: each marked person is followed by a tracker of its own.
//!
//! ```text
//!  mark is set --an object is proposed there--> followed --tracker loses it--> searched for where it must be
//!                     |                             ^                                  |
//!                     +-- nothing: not held         +-- found there, by the rules of the boat's tracker
//! ```
//!
//! The boat is tracked first. Marks share what is left of a step: at most [`TRACKED_PER_FRAME`] of them are
//! tracked in a frame, in turns, one of them in search of a lost object. The work is bounded by counts, not by
//! time, so that a replay repeats it.
//!
//! What must not be here: where a mark is on the water (`vessel::holding`), and whether the boat may go there.

use barrelman_vision::{FusedConfig, FusedTracker, ObjectSizes, Proposer, Tracker};
use barrelman_vocab::{MotionPrior, PictureSize, PixelBox, PixelPoint, Timestamp, Track, VideoFrame};

use crate::history::FrameHistory;

/// Most marks that are held at a time.
pub(crate) const MAX_HELD: usize = 8;
/// Marks that are tracked in one video frame.
const TRACKED_PER_FRAME: usize = 2;
/// Frames in which a new mark's object must be measured before the mark is said to be held.
const CONFIRMING_FRAMES: u32 = 4;
/// Least IoU of the boxes of two objects that are one.
const SAME_OBJECT_IOU: f64 = 0.3;

/// Shift of the picture between two times of capture.
pub(crate) type PictureShift<'a> = &'a dyn Fn(Timestamp, Timestamp, PictureSize) -> MotionPrior;

/// The tracker of one mark.
pub(crate) struct HeldMark {
    /// Number of the mark.
    pub(crate) id: u32,
    /// The newest answer.
    pub(crate) track: Track,
    /// Whether the answer is of the newest video frame.
    pub(crate) is_current: bool,
    /// Pixel at which the mark must be; `None`: behind the camera.
    pub(crate) expected: Option<PixelPoint>,
    tracker: Box<FusedTracker>,
    processed: Timestamp,
    /// Frames in which the object was measured, up to [`CONFIRMING_FRAMES`].
    measured: u32,
}

impl HeldMark {
    /// The track to report; `None` before the object is confirmed.
    pub(crate) fn reported(&self) -> Option<Track> {
        (self.measured >= CONFIRMING_FRAMES).then_some(self.track)
    }

    /// What the tracker follows is not what is marked: it is searched for.
    pub(crate) fn reject(&mut self) {
        self.tracker.reject();
        self.track = Track::Lost { since: self.processed, confidence: 0.0 };
    }

    /// What is marked is hidden: it was not measured in this frame.
    pub(crate) fn hide(&mut self) {
        if let Track::Tracking(seen) = self.track {
            self.track = Track::Coasting(seen);
        }
    }

    fn is_lost(&self) -> bool {
        matches!(self.track, Track::Lost { .. })
    }

    /// Whether the picture shows the place at which the mark must be.
    fn is_expected_in(&self, picture: PictureSize) -> bool {
        self.expected.is_some_and(|PixelPoint { u, v }| {
            (0.0..f64::from(picture.width)).contains(&u) && (0.0..f64::from(picture.height)).contains(&v)
        })
    }

    fn advance(&mut self, frame: &VideoFrame, shift: PictureShift<'_>) {
        let now = frame.capture.at;
        if let Some(place) = self.expected.filter(|_| self.is_lost()) {
            self.tracker.expect_lost_at(place);
        }
        let prior = (self.processed <= now).then(|| shift(self.processed, now, frame.picture.size()));
        self.track = self.tracker.track(frame, prior.as_ref());
        (self.processed, self.is_current) = (now, true);
        if matches!(self.track, Track::Tracking(_)) {
            self.measured = (self.measured + 1).min(CONFIRMING_FRAMES);
        }
    }

    /// Distance of the object from where the mark must be, pixels.
    fn distance_px(&self, seen: PixelBox) -> f64 {
        let centre = seen.centre();
        self.expected.map_or(0.0, |at| libm::hypot(centre.u - at.u, centre.v - at.v))
    }
}

/// The marks that are held.
#[derive(Default)]
pub(crate) struct HeldMarks {
    marks: Vec<HeldMark>,
    /// Trackers of marks that were released, for their buffers.
    spare: Vec<Box<FusedTracker>>,
    proposer: Option<Box<Proposer>>,
    /// Index of the mark that is tracked first in the next frame.
    next: usize,
}

impl HeldMarks {
    /// The marks that are held, or may be held once they are confirmed.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut HeldMark> {
        self.marks.iter_mut()
    }

    /// The boxes of what is held.
    pub(crate) fn boxes(&self) -> impl Iterator<Item = PixelBox> + Clone {
        self.marks.iter().filter_map(|held| held.track.localisation()).map(|seen| seen.bounds)
    }

    /// Begins to hold a mark that was set or moved at a pixel of a video frame. Nothing is held where no object
    /// is found there, where the object is the `boat`, or is held already, and while [`MAX_HELD`] marks are held.
    pub(crate) fn hold(
        &mut self,
        id: u32,
        (at, captured): (PixelPoint, Timestamp),
        history: &FrameHistory,
        boat: Option<PixelBox>,
    ) {
        self.keep(|held| held != id);
        if self.marks.len() >= MAX_HELD {
            return;
        }
        let Some(frame) = history.find(captured) else { return };
        let sizes = ObjectSizes::in_picture_of_height(frame.picture.size().height);
        let proposer = self.proposer.get_or_insert_default();
        let Ok(proposed) = proposer.propose(&frame.picture, at, sizes) else { return };
        if self.boxes().chain(boat).any(|other| is_same(other, proposed.bounds)) {
            return;
        }
        let made = || FusedTracker::new(FusedConfig::default()).ok().map(Box::new);
        let Some(mut tracker) = self.spare.pop().or_else(made) else { return };
        match tracker.select(frame, proposed.bounds) {
            Ok(report) => self.marks.push(HeldMark {
                id,
                track: Track::Tracking(report.localisation),
                is_current: false,
                expected: Some(at),
                tracker,
                processed: frame.capture.at,
                measured: 0,
            }),
            Err(_) => self.spare.push(tracker),
        }
    }

    /// Releases all marks but those with these numbers.
    pub(crate) fn keep(&mut self, is_kept: impl Fn(u32) -> bool) {
        let mut index = 0;
        while let Some(held) = self.marks.get(index) {
            if is_kept(held.id) {
                index += 1;
            } else {
                let mut released = self.marks.remove(index).tracker;
                released.forget();
                self.spare.push(released);
            }
        }
    }

    /// Tracks the marks whose turn it is in the newest frame.
    pub(crate) fn advance(&mut self, frame: &VideoFrame, shift: PictureShift<'_>) {
        let count = self.marks.len();
        let (mut tracked, mut has_searched, mut last) = (0, false, self.next);
        self.marks.iter_mut().for_each(|held| held.is_current = false);
        for index in (0..count).map(|offset| (self.next + offset) % count) {
            if tracked == TRACKED_PER_FRAME {
                break;
            }
            let Some(held) = self.marks.get_mut(index) else { break };
            if held.is_lost() {
                if has_searched || !held.is_expected_in(frame.picture.size()) {
                    continue;
                }
                has_searched = true;
            }
            held.advance(frame, shift);
            (tracked, last) = (tracked + 1, index);
        }
        self.next = if count == 0 { 0 } else { (last + 1) % count };
        let failed = |held: &HeldMark| held.measured < CONFIRMING_FRAMES && held.is_lost();
        while let Some(id) = self.marks.iter().find(|held| failed(held)).map(|held| held.id) {
            self.keep(|held| held != id);
        }
    }

    /// Two marks never hold one object: the one that expected it farther away loses it. An object within the
    /// box of the boat is hidden by it.
    pub(crate) fn separate(&mut self, boat: Option<PixelBox>) {
        for index in 0..self.marks.len() {
            let (before, rest) = self.marks.split_at_mut(index);
            let Some(held) = rest.first_mut() else { break };
            let Track::Tracking(seen) = held.track else { continue };
            if boat.is_some_and(|boat| is_same(boat, seen.bounds) || contains(boat, seen.bounds.centre())) {
                held.hide();
                continue;
            }
            for other in before {
                let Track::Tracking(other_seen) = other.track else { continue };
                if is_same(seen.bounds, other_seen.bounds) {
                    if held.distance_px(seen.bounds) < other.distance_px(other_seen.bounds) {
                        other.reject();
                    } else {
                        held.reject();
                        break;
                    }
                }
            }
        }
    }
}

fn contains(PixelBox { u, v, w, h }: PixelBox, point: PixelPoint) -> bool {
    (u..=u + w).contains(&point.u) && (v..=v + h).contains(&point.v)
}

/// Whether two boxes are those of one object.
fn is_same(one: PixelBox, other: PixelBox) -> bool {
    one.iou(other) >= SAME_OBJECT_IOU
}
