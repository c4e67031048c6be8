//! What was detected last, and how long it counts.

use core::time::Duration;

use barrelman_vocab::{PictureSize, Timestamp, VideoFrame};

use crate::detections::{Classification, Detection, Detections, MAX_DETECTIONS, is_recent};

/// How long a classification is shown after the detector last gave it.
const CLASSIFICATION_LASTS: Duration = Duration::from_secs(3);

/// What was detected last, and was not used yet.
#[derive(Default)]
pub(super) struct Detected {
    /// Time of capture and picture of the frame; `None`: nothing was detected yet.
    frame: Option<(Timestamp, PictureSize)>,
    /// The highest score last.
    pub(super) waiting: Vec<Detection>,
}

impl Detected {
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }

    pub(super) fn set(&mut self, detections: &Detections) {
        self.frame = Some((detections.captured, detections.picture));
        self.waiting.clear();
        self.waiting.reserve(MAX_DETECTIONS);
        self.waiting.extend(detections.found.iter().take(MAX_DETECTIONS).rev());
    }

    /// Time of capture of the detections; `None` where they do not concern a frame.
    pub(super) fn captured_before(&self, frame: &VideoFrame) -> Option<Timestamp> {
        let detected = self.frame?;
        is_recent(detected, (frame.capture.at, frame.picture.size())).then_some(detected.0)
    }
}

/// A classification, and the time of capture that it was last given for.
pub(super) type Given = Option<(Classification, Timestamp)>;

/// The classification, while it lasts.
pub(super) fn current(given: Given, now: Timestamp) -> Given {
    given.filter(|(_, at)| *at <= now && now.since(*at) <= CLASSIFICATION_LASTS)
}
