//! The source of video frames of a trial in pixels.

use barrelman_sim::World;
use barrelman_vocab::VideoFrame;

use crate::target_in_picture::TargetInPicture;

/// Captures video frames of a simulated world.
pub trait FrameSource {
    /// Captures the world in its present state.
    fn capture(&mut self, world: &World) -> CapturedFrame;
    /// Returns the video frame that the pilot receives for a captured one. The two differ where a codec lies
    /// between camera and pilot.
    fn deliver(&mut self, captured: &CapturedFrame) -> VideoFrame {
        captured.frame.clone()
    }
}

/// A video frame with its truth.
#[derive(Debug, Clone)]
pub struct CapturedFrame {
    /// The video frame.
    pub frame: VideoFrame,
    /// What the frame shows of the target.
    pub target: TargetInPicture,
}
