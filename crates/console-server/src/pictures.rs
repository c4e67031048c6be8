//! The newest video frame as JPEG for the pages, on a thread of its own, and only while a page asks for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use barrelman_host::latest::Latest;
use barrelman_pilot::Outcome;
use barrelman_video::jpeg;
use barrelman_vocab::{VehicleRates, VideoFrame, VideoNumber};
use bytes::Bytes;
use tokio::sync::watch;

use super::api::VideoHead;
use super::newest_picture::NewestPicture;

/// Interval at which the thread looks for a page that asks for pictures.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// The newest video frame, and the newest JPEG of one.
#[derive(Debug)]
pub struct PictureSlot {
    number: VideoNumber,
    frames: Latest<VideoFrame>,
    pictures: watch::Sender<Bytes>,
    viewers: AtomicUsize,
    /// For programs, which ask for one picture.
    pub(super) newest: NewestPicture,
}

impl PictureSlot {
    /// No picture so far of this video.
    pub fn new(number: VideoNumber) -> Self {
        Self {
            number,
            frames: Latest::default(),
            pictures: watch::Sender::new(Bytes::new()),
            viewers: AtomicUsize::new(0),
            newest: NewestPicture::default(),
        }
    }
}

/// A page that receives pictures. Dropping it ends the subscription.
#[derive(Debug)]
pub(super) struct PictureViewer {
    slot: Arc<PictureSlot>,
    pictures: watch::Receiver<Bytes>,
}

impl PictureViewer {
    /// Subscribes to the pictures. The first picture is the newest one, if there is one.
    pub(super) fn new(slot: Arc<PictureSlot>) -> Self {
        slot.viewers.fetch_add(1, Ordering::Relaxed);
        let mut pictures = slot.pictures.subscribe();
        if !pictures.borrow().is_empty() {
            pictures.mark_changed();
        }
        Self { slot, pictures }
    }

    /// Waits for the next picture, as a message. `None` at the end of the session.
    pub(super) async fn next(&mut self) -> Option<Bytes> {
        self.pictures.changed().await.ok()?;
        Some(self.pictures.borrow_and_update().clone())
    }
}

impl Drop for PictureViewer {
    fn drop(&mut self) {
        self.slot.viewers.fetch_sub(1, Ordering::Relaxed);
    }
}

impl PictureSlot {
    /// The newest video frame, and what the pilot made of it. The picture is shared, not copied.
    pub fn put(&self, frame: &VideoFrame, outcome: &Outcome, rates: VehicleRates) {
        self.newest.put(frame, outcome, rates);
        self.show(frame);
    }

    /// The newest frame of a video that the pilot does not see.
    pub fn show(&self, frame: &VideoFrame) {
        self.frames.put(frame.clone());
    }

    /// Ends the thread that encodes.
    pub fn close(&self) {
        self.frames.close();
    }

    fn has_viewer(&self) -> bool {
        self.viewers.load(Ordering::Relaxed) > 0
    }
}

/// Encodes the newest frame, again and again, until the slot is closed.
pub(super) fn encode_pictures(slot: &PictureSlot) {
    while let Some(frame) = slot.frames.wait_until_wanted(POLL_INTERVAL, || slot.has_viewer()) {
        match jpeg::encode(&frame.picture) {
            Ok(payload) => {
                slot.pictures
                    .send_replace(VideoHead::of_picture(&frame, slot.number).message(&payload).into());
            }
            Err(error) => tracing::error!("a picture for the console cannot be encoded: {error}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::api::{HEAD_BYTES, VideoKind};
    use super::super::in_memory::block_on;
    use super::*;
    use crate::test_scenes::{at, frame, idle};

    fn put(slot: &PictureSlot, number: u64) {
        slot.put(&frame(number, at(number)), &idle(at(number)), VehicleRates::REST);
    }

    /// The number of the frame, its time of capture and its size, from the head of a message.
    fn head_of(message: &[u8]) -> (u64, u64, u16, u16) {
        let number = |from: usize| u64::from_le_bytes(message[from..from + 8].try_into().unwrap());
        let side = |from: usize| u16::from_le_bytes(message[from..from + 2].try_into().unwrap());
        (number(16), number(8), side(24), side(26))
    }

    #[test]
    fn every_page_that_asks_gets_the_newest_frame_as_jpeg() {
        let slot = Arc::new(PictureSlot::new(VideoNumber::First));
        let mut first = PictureViewer::new(Arc::clone(&slot));
        put(&slot, 6);
        put(&slot, 7);
        let received = std::thread::scope(|scope| {
            scope.spawn(|| encode_pictures(&slot));
            let next = |viewer: &mut PictureViewer| block_on(viewer.next()).unwrap_or_default();
            let shown = next(&mut first);
            let mut second = PictureViewer::new(Arc::clone(&slot));
            let shown_again = next(&mut second);
            put(&slot, 8);
            let later = [next(&mut first), next(&mut second)];
            slot.close();
            (shown, shown_again, later)
        });
        let (shown, shown_again, later) = received;
        assert_eq!(head_of(&shown), (7, at(7).as_nanos(), 640, 480));
        assert_eq!(shown[1], VideoKind::Jpeg as u8);
        assert_eq!(shown[HEAD_BYTES..HEAD_BYTES + 2], [0xff, 0xd8], "a JPEG file begins so");
        assert_eq!(shown_again, shown, "a new page gets the picture that is there");
        assert_eq!(later.map(|message| head_of(&message).0), [8, 8]);
    }

    #[test]
    fn pictures_are_wanted_while_a_page_shows_them() {
        let slot = Arc::new(PictureSlot::new(VideoNumber::First));
        assert!(!slot.has_viewer());
        let viewers = [PictureViewer::new(Arc::clone(&slot)), PictureViewer::new(Arc::clone(&slot))];
        let [first, second] = viewers;
        drop(first);
        assert!(slot.has_viewer());
        drop(second);
        assert!(!slot.has_viewer());
    }
}
