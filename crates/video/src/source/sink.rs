//! What a source tells whoever takes its pictures.

use barrelman_vocab::PixelBox;
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::VideoFrame;

use crate::error::{DecodeError, VideoError};

/// Takes what a source delivers. Called on the video thread; must not block.
pub trait VideoSink: Send {
    /// An encoded unit, just before the frame that it gives.
    fn unit(&mut self, unit: &EncodedUnit);
    /// A decoded frame.
    fn frame(&mut self, frame: VideoFrame);
    /// The source changed its state.
    fn state(&mut self, state: VideoState);
    /// Where the target is in the frame that comes next: told once, by a simulated world, at the first frame in which
    /// the target is seen.
    fn target(&mut self, _target: PixelBox) {}
    /// A unit was damaged; nothing is shown until the next key frame.
    fn damaged(&mut self, _error: &DecodeError) {}
}

/// How a source stands.
#[derive(Debug)]
pub enum VideoState {
    /// An attempt to connect, or to open, begins.
    Connecting,
    /// The first frame after connecting is about to come.
    Up,
    /// The source is gone, and will be tried again.
    Lost {
        /// What happened, in words.
        reason: String,
    },
    /// The file is at its end; nothing more will come.
    Ended,
    /// The source can never be shown; nothing more will come.
    Failed(VideoError),
}
