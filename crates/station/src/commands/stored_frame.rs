//! One frame of a stored video.

use anyhow::{Result, bail};
use barrelman_video::{DecodeError, VideoError, VideoFrames, VideoUrl};
use barrelman_vocab::VideoFrame;

/// The frame with this number, counted from 0 as `track` counts: damaged pictures are left out.
///
/// # Errors
/// If the video cannot be read, or has fewer frames; the message says how many.
pub(super) fn stored_frame(url: &VideoUrl, number: u64) -> Result<VideoFrame> {
    let mut frames = VideoFrames::open(url)?;
    let mut index = 0;
    loop {
        match frames.next_frame() {
            Ok(Some(frame)) if index == number => return Ok(frame),
            Ok(Some(_)) => index += 1,
            Ok(None) => bail!("{url} has {index} frames: there is no frame {number}"),
            Err(VideoError::Decode { cause: DecodeError::Damaged { .. }, .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
}
