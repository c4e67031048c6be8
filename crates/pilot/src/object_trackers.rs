//! Trackers of objects beside the boat: of marked people, and of candidates. Each object has a tracker of its
//! own.
//!
//! The boat is tracked first. The others share what is left of a step: at most [`TRACKED_PER_FRAME`] of them
//! are tracked in a frame, in turns, one of them in search of a lost object. The work is bounded by counts,
//! not by time, so that a replay repeats it.

use barrelman_vision::{FusedConfig, FusedTracker, Tracker};
use barrelman_vocab::{
    Localisation, MotionPrior, PictureSize, PixelBox, PixelPoint, Timestamp, Track, VideoFrame,
};

/// Most objects at a time.
pub(crate) const MAX_OBJECTS: usize = 8;
/// Objects that are tracked in one video frame.
const TRACKED_PER_FRAME: usize = 2;
/// Frames in which a new object must be measured before it is reported.
const CONFIRMING_FRAMES: u32 = 4;
/// Least IoU of the boxes of two objects that are one.
const SAME_OBJECT_IOU: f64 = 0.3;

/// Shift of the picture between two times of capture.
pub(crate) type PictureShift<'a> = &'a dyn Fn(Timestamp, Timestamp, PictureSize) -> MotionPrior;

/// One object with its tracker.
pub(crate) struct TrackedObject {
    /// Number of the mark, or of the candidate.
    pub(crate) id: u32,
    /// The newest answer.
    pub(crate) track: Track,
    /// Whether the answer is of the newest video frame.
    pub(crate) is_current: bool,
    /// Whether the object was not measured in the frame before that.
    pub(crate) is_back: bool,
    /// Pixel at which the object must be; `None`: behind the camera, or not known.
    pub(crate) expected: Option<PixelPoint>,
    tracker: Box<FusedTracker>,
    processed: Timestamp,
    /// Frames in which the object was measured, up to [`CONFIRMING_FRAMES`].
    measured: u32,
}

impl TrackedObject {
    /// The track to report; `None` before the object is confirmed.
    pub(crate) fn reported(&self) -> Option<Track> {
        (self.measured >= CONFIRMING_FRAMES).then_some(self.track)
    }

    /// What the tracker follows is not the object: the object is searched for.
    pub(crate) fn lose(&mut self) {
        self.tracker.lose();
        self.track = Track::Lost { since: self.processed, confidence: 0.0 };
    }

    /// The object is hidden: it was not measured in this frame.
    pub(crate) fn hide(&mut self) {
        if let Track::Tracking(seen) = self.track {
            self.track = Track::Coasting(seen);
        }
    }

    fn is_lost(&self) -> bool {
        matches!(self.track, Track::Lost { .. })
    }

    /// Whether the picture shows the place at which the object must be.
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
        self.is_back = !matches!(self.track, Track::Tracking(_));
        self.track = self.tracker.track(frame, prior.as_ref());
        (self.processed, self.is_current) = (now, true);
        if matches!(self.track, Track::Tracking(_)) {
            self.measured = (self.measured + 1).min(CONFIRMING_FRAMES);
        }
    }

    /// Distance of what was measured from where the object must be, pixels.
    fn distance_px(&self, seen: PixelBox) -> f64 {
        let centre = seen.centre();
        self.expected.map_or(0.0, |at| libm::hypot(centre.u - at.u, centre.v - at.v))
    }
}

/// The objects.
#[derive(Default)]
pub(crate) struct ObjectTrackers {
    objects: Vec<TrackedObject>,
    /// Trackers of objects that were released, for their buffers.
    spare: Vec<Box<FusedTracker>>,
    /// Index of the object that is tracked first in the next frame.
    next: usize,
}

impl ObjectTrackers {
    /// The objects, confirmed or not.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut TrackedObject> {
        self.objects.iter_mut()
    }

    /// Where the tracker of an object sees it, or predicts it; `None`: nowhere, or there is none.
    pub(crate) fn seen(&self, id: u32) -> Option<&Localisation> {
        self.objects.iter().find(|object| object.id == id)?.track.localisation()
    }

    /// The boxes of the objects.
    pub(crate) fn boxes(&self) -> impl Iterator<Item = PixelBox> + Clone {
        self.objects.iter().filter_map(|object| object.track.localisation()).map(|seen| seen.bounds)
    }

    /// Whether a box is that of an object, or of one of these others.
    pub(crate) fn are_at(&self, bounds: PixelBox, others: impl IntoIterator<Item = PixelBox>) -> bool {
        self.boxes().chain(others).any(|other| is_same(other, bounds))
    }

    /// Tracks the object of a box in a video frame. Returns whether it can be tracked; not while there are
    /// [`MAX_OBJECTS`].
    pub(crate) fn add(&mut self, id: u32, bounds: PixelBox, frame: &VideoFrame) -> bool {
        if self.objects.len() >= MAX_OBJECTS {
            return false;
        }
        let made = || FusedTracker::new(FusedConfig::default()).ok().map(Box::new);
        let Some(mut tracker) = self.spare.pop().or_else(made) else { return false };
        let Ok(report) = tracker.select(frame, bounds) else {
            self.spare.push(tracker);
            return false;
        };
        self.objects.push(TrackedObject {
            id,
            // What is seen first must be where the person was marked, as what is found after a loss.
            track: Track::Coasting(report.localisation),
            is_current: false,
            is_back: false,
            expected: Some(bounds.centre()),
            tracker,
            processed: frame.capture.at,
            measured: 0,
        });
        true
    }

    /// Releases all objects but those with these numbers.
    pub(crate) fn keep(&mut self, is_kept: impl Fn(u32) -> bool) {
        let mut index = 0;
        while let Some(object) = self.objects.get(index) {
            if is_kept(object.id) {
                index += 1;
            } else {
                let mut released = self.objects.remove(index).tracker;
                released.forget();
                self.spare.push(released);
            }
        }
    }

    /// Tracks the objects whose turn it is in the newest frame.
    pub(crate) fn advance(&mut self, frame: &VideoFrame, shift: PictureShift<'_>) {
        let count = self.objects.len();
        let (mut tracked, mut has_searched, mut last) = (0, false, self.next);
        self.objects.iter_mut().for_each(|object| object.is_current = false);
        for index in (0..count).map(|offset| (self.next + offset) % count) {
            if tracked == TRACKED_PER_FRAME {
                break;
            }
            let Some(object) = self.objects.get_mut(index) else { break };
            if object.is_lost() {
                if has_searched || !object.is_expected_in(frame.picture.size()) {
                    continue;
                }
                has_searched = true;
            }
            object.advance(frame, shift);
            (tracked, last) = (tracked + 1, index);
        }
        self.next = if count == 0 { 0 } else { (last + 1) % count };
        let failed = |object: &TrackedObject| object.measured < CONFIRMING_FRAMES && object.is_lost();
        while let Some(id) = self.objects.iter().find(|object| failed(object)).map(|object| object.id) {
            self.keep(|object| object != id);
        }
    }

    /// Two trackers never follow one object: the one that expected it farther away loses it. An object within
    /// the box of the boat is hidden by it.
    pub(crate) fn separate(&mut self, boat: Option<PixelBox>) {
        for index in 0..self.objects.len() {
            let (before, rest) = self.objects.split_at_mut(index);
            let Some(object) = rest.first_mut() else { break };
            let Track::Tracking(seen) = object.track else { continue };
            if boat.is_some_and(|boat| is_same(boat, seen.bounds) || boat.contains(seen.bounds.centre())) {
                object.hide();
                continue;
            }
            for other in before {
                let Track::Tracking(other_seen) = other.track else { continue };
                if is_same(seen.bounds, other_seen.bounds) {
                    if object.distance_px(seen.bounds) < other.distance_px(other_seen.bounds) {
                        other.lose();
                    } else {
                        object.lose();
                        break;
                    }
                }
            }
        }
    }
}

/// Whether two boxes are those of one object.
fn is_same(one: PixelBox, other: PixelBox) -> bool {
    one.iou(other) >= SAME_OBJECT_IOU
}
