//! The video frames of the last second and a half, for selections that were drawn on an earlier frame.

use std::collections::VecDeque;

use core::time::Duration;

use barrelman_vocab::{Timestamp, VideoFrame};

use crate::outcome::Refusal;

/// How long a video frame is kept after its capture. An operator draws a box within a second.
pub(crate) const KEPT: Duration = Duration::from_millis(1500);
/// Largest number of frames that are kept: 1.5 s at 60 frames a second.
const CAPACITY: usize = 96;
/// Largest size of the kept pictures together, bytes. A frame of 1280 x 720 pixels takes 1.4 MB: at 30 frames
/// a second, 46 frames take 64 MB. Of pictures of 3840 x 2160 pixels 21 frames are kept, 0.7 s.
const MAX_BYTES: usize = 256 << 20;
/// A selection whose frame was not processed is applied to the nearest one within this time.
const NEAREST: Duration = Duration::from_millis(50);

/// The newest video frames that the pilot processed, oldest first.
#[derive(Debug, Default)]
pub(crate) struct FrameHistory {
    frames: VecDeque<VideoFrame>,
    is_kept: bool,
}

impl FrameHistory {
    /// A history that keeps frames, with all its memory but that of the pictures.
    pub(crate) fn keeping() -> Self {
        Self { frames: VecDeque::with_capacity(CAPACITY), is_kept: true }
    }

    /// Whether frames are kept.
    pub(crate) const fn is_kept(&self) -> bool {
        self.is_kept
    }

    /// Adds the newest frame. Times of capture that run backwards begin anew.
    pub(crate) fn add(&mut self, frame: &VideoFrame) {
        if !self.is_kept {
            return;
        }
        let now = frame.capture.at;
        if self.frames.back().is_some_and(|last| last.capture.at > now) {
            self.frames.clear();
        }
        // Luma and two chroma planes of a quarter each.
        let bytes = frame.picture.size().area() * 3 / 2;
        let capacity = (MAX_BYTES / bytes.max(1)).clamp(1, CAPACITY);
        while self.frames.len() >= capacity
            || self.frames.front().is_some_and(|first| now.since(first.capture.at) > KEPT)
        {
            self.frames.pop_front();
        }
        self.frames.push_back(frame.clone());
    }

    /// Forgets all frames: those that follow are of another video.
    pub(crate) fn clear(&mut self) {
        self.frames.clear();
    }

    /// The frame captured at `captured`, or the nearest one in time.
    pub(crate) fn find(&self, captured: Timestamp) -> Option<&VideoFrame> {
        let distance = |frame: &&VideoFrame| {
            let at = frame.capture.at;
            if at > captured { at.since(captured) } else { captured.since(at) }
        };
        self.frames.iter().min_by_key(distance).filter(|frame| distance(frame) <= NEAREST)
    }

    /// The frames captured after `captured`, oldest first.
    pub(crate) fn after(&self, captured: Timestamp) -> impl Iterator<Item = &VideoFrame> {
        self.frames.iter().skip_while(move |frame| frame.capture.at <= captured)
    }

    /// The newest frame that is kept.
    pub(crate) fn newest(&self) -> Option<&VideoFrame> {
        self.frames.back()
    }
}

/// Why nothing is selected on a frame that [`FrameHistory::find`] does not find. `newest`: when the newest
/// frame was captured.
pub(crate) fn not_kept(captured: Timestamp, newest: Timestamp) -> Refusal {
    if captured > newest {
        return Refusal::NotYetCaptured;
    }
    Refusal::SelectionTooOld { age: newest.since(captured), kept: KEPT }
}
