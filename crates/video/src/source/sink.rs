//! The receiver of a video source, and the states of a source.

use barrelman_vocab::PixelBox;
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::VideoFrame;

use super::sender_clock::VideoTiming;
use crate::error::{DecodeError, VideoError};

/// Receives the output of a video source. The methods are called on the video thread and must not block.
pub trait VideoSink: Send {
    /// An encoded unit, directly before its frame.
    fn on_unit(&mut self, unit: &EncodedUnit);
    /// A decoded frame.
    fn on_frame(&mut self, frame: VideoFrame);
    /// A new state of the source.
    fn on_state(&mut self, state: VideoState);
    /// What the times of the pictures tell has changed. Sources with exact times never call this.
    fn on_timing(&mut self, _timing: VideoTiming) {}
    /// The target's bounds in the next frame. A simulated world calls this once, before the first frame that
    /// shows the target.
    fn on_target(&mut self, _target: PixelBox) {}
    /// A unit was damaged: no frame follows until the next key frame.
    fn on_damage(&mut self, _error: &DecodeError) {}
}

/// The state of a source.
#[derive(Debug)]
pub enum VideoState {
    /// The source is being connected or opened.
    Connecting,
    /// Frames arrive; sent directly before the first frame.
    Up,
    /// The connection was lost; the source reconnects.
    Lost {
        /// The reason, for people.
        reason: String,
    },
    /// The end of the file: no frame follows.
    Ended,
    /// The source cannot be used: no frame follows.
    Failed(VideoError),
}
