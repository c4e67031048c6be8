//! The newest video frame: one that was not taken in time is replaced, and counted.

use std::sync::{Mutex, PoisonError};

use barrelman_vocab::VideoFrame;

/// A place for one frame.
#[derive(Debug, Default)]
pub struct LatestFrame {
    slot: Mutex<Slot>,
}

#[derive(Debug, Default)]
struct Slot {
    frame: Option<VideoFrame>,
    replaced: u64,
}

impl LatestFrame {
    /// Puts a frame in. Returns whether the place was empty, that is, whether somebody must be told.
    pub fn put(&self, frame: VideoFrame) -> bool {
        let mut slot = self.slot.lock().unwrap_or_else(PoisonError::into_inner);
        let replaced = slot.frame.replace(frame).is_some();
        slot.replaced += u64::from(replaced);
        !replaced
    }

    /// Takes the frame out, with the number of frames that were replaced so far.
    pub fn take(&self) -> (Option<VideoFrame>, u64) {
        let mut slot = self.slot.lock().unwrap_or_else(PoisonError::into_inner);
        (slot.frame.take(), slot.replaced)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
    use barrelman_vocab::{Picture, PictureSize, Timestamp};

    use super::*;

    fn frame(sequence: u64) -> VideoFrame {
        VideoFrame {
            sequence,
            capture: Capture { at: Timestamp::ZERO, quality: CaptureQuality::Sensor },
            picture: Arc::new(Picture::black(PictureSize::new(2, 2), ColourEncoding::JPEG)),
        }
    }

    #[test]
    fn the_newest_frame_wins_and_the_others_are_counted() {
        let latest = LatestFrame::default();
        assert_eq!([latest.put(frame(0)), latest.put(frame(1)), latest.put(frame(2))], [true, false, false]);
        let (taken, replaced) = latest.take();
        assert_eq!((taken.map(|frame| frame.sequence), replaced), (Some(2), 2));
        assert!(latest.take().0.is_none());
        assert!(latest.put(frame(3)));
    }
}
