//! A tracker that knows what each picture shows: video frames come to the pilot as from a camera, with their
//! time of capture also where the boat is not found.

use std::sync::{Arc, Mutex, PoisonError};

use barrelman_vision::{Explanation, SelectionError, SelectionReport, Tracker};
use barrelman_vocab::{MotionPrior, PixelBox, Timestamp, Track, VideoFrame};

use super::super::picture::SeenPicture;

/// What the newest picture shows; shared with the one who passes the pictures on.
pub(super) type Truth = Arc<Mutex<Option<SeenPicture>>>;

/// The tracker.
pub(super) struct TruthTracker {
    truth: Truth,
    lost_since: Option<Timestamp>,
}

impl TruthTracker {
    pub(super) const fn new(truth: Truth) -> Self {
        Self { truth, lost_since: None }
    }
}

impl Tracker for TruthTracker {
    /// Nothing is selected in this campaign: the boat is known.
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        Err(SelectionError::Empty { selection, picture: frame.picture.size() })
    }

    fn track(&mut self, frame: &VideoFrame, _: Option<&MotionPrior>) -> Track {
        let seen = *self.truth.lock().unwrap_or_else(PoisonError::into_inner);
        let track = seen.map_or(Track::Unseeded, |picture| picture.track(frame.capture.at, self.lost_since));
        self.lost_since = match track {
            Track::Lost { since, .. } => Some(since),
            _ => None,
        };
        track
    }

    fn forget(&mut self) {}

    fn reject(&mut self) -> bool {
        false
    }

    fn explain(&self, _: &mut Explanation) {}
}
