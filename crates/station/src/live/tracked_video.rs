//! Which of two videos the pilot sees.
//!
//! Both videos are received, decoded, recorded and shown all the time. The pilot gets the frames of one, the
//! tracked one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use barrelman_host::latest::Latest;
use barrelman_vocab::{VideoFrame, VideoNumber};

/// The slot of the newest frame of the tracked video.
pub type LatestFrame = Latest<(VideoNumber, VideoFrame)>;

/// The number of the tracked video. The loop sets it; the threads of the videos read it.
#[derive(Debug, Clone, Default)]
pub struct TrackedVideo(Arc<AtomicBool>);

impl TrackedVideo {
    /// The number.
    pub fn number(&self) -> VideoNumber {
        if self.0.load(Ordering::Relaxed) { VideoNumber::Second } else { VideoNumber::First }
    }

    /// The video is the tracked one from now on.
    pub(super) fn choose(&self, number: VideoNumber) {
        self.0.store(number == VideoNumber::Second, Ordering::Relaxed);
    }
}
