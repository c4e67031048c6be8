//! The video of a recording, decoded on demand.
//!
//! A recording may hold any number of units whose frame no step needs, and a small unit may be a large
//! picture. So units are queued encoded, up to a number of bytes, and decoded in order until the wanted frame
//! comes. Decoded frames are queued only where one unit gives several: the frames that the decoder held back,
//! at most sixteen.

use std::collections::VecDeque;

use anyhow::{Result, anyhow, bail};
use barrelman_trial::records::FrameFingerprint;
use barrelman_vocab::{EncodedUnit, VideoFrame};

use barrelman_video::decoder::UnitDecoder;
use barrelman_video::mode::DecodeMode;

/// Queued units of a video that no step uses, bytes.
const MAX_UNUSED_BYTES: usize = 64 << 20;

/// The video of a recording.
pub struct StoredVideo {
    decoder: UnitDecoder,
    units: VecDeque<EncodedUnit>,
    /// Bytes of the queued units.
    queued_bytes: usize,
    max_queued_bytes: usize,
    decoded: VecDeque<VideoFrame>,
    ended: bool,
}

impl StoredVideo {
    /// A video without units. At most `max_queued_bytes` of units are queued.
    pub fn new(mode: DecodeMode, max_queued_bytes: usize) -> Self {
        Self {
            decoder: UnitDecoder::new(mode),
            units: VecDeque::new(),
            queued_bytes: 0,
            max_queued_bytes,
            decoded: VecDeque::new(),
            ended: false,
        }
    }

    /// Queues the next unit.
    ///
    /// # Errors
    /// If the queued units exceed the limit.
    pub fn add(&mut self, unit: EncodedUnit) -> Result<()> {
        self.queued_bytes += bytes_of(&unit);
        if self.queued_bytes > self.max_queued_bytes {
            bail!(
                "its video runs too far ahead of its steps: at picture {}, more than {} MiB wait for a step that uses \
                 them; `barrelman export` extracts the video",
                unit.index,
                self.max_queued_bytes >> 20
            );
        }
        self.units.push_back(unit);
        Ok(())
    }

    /// Queues the next unit of a video that no step uses just now. Where much of it waits, the oldest is
    /// decoded and dropped: the decoder has to have seen it before a later picture.
    pub fn add_unused(&mut self, unit: EncodedUnit) {
        self.queued_bytes += bytes_of(&unit);
        self.units.push_back(unit);
        while self.queued_bytes > MAX_UNUSED_BYTES
            && let Some(oldest) = self.units.pop_front()
        {
            self.queued_bytes -= bytes_of(&oldest);
            self.decoded.clear();
            let _ = self.decoder.decode(&oldest, &mut |frame| self.decoded.push_back(frame));
        }
    }

    /// The frame of a fingerprint, with the recorded time of capture.
    ///
    /// # Errors
    /// If the units so far do not contain the frame, or its picture differs from the recorded one.
    pub fn frame(&mut self, fingerprint: &FrameFingerprint) -> Result<VideoFrame> {
        let mut frame = self
            .next_from(fingerprint.sequence)
            .filter(|frame| frame.sequence == fingerprint.sequence)
            .ok_or_else(|| anyhow!("video frame {} is not in the recording", fingerprint.sequence))?;
        if FrameFingerprint::from_frame(fingerprint.video, &frame).luma_hash != fingerprint.luma_hash {
            return Err(OtherPicture { sequence: fingerprint.sequence }.into());
        }
        frame.capture = fingerprint.capture;
        Ok(frame)
    }

    /// The next frame with this sequence number or a higher one.
    fn next_from(&mut self, sequence: u64) -> Option<VideoFrame> {
        loop {
            while let Some(frame) = self.decoded.pop_front() {
                if frame.sequence >= sequence {
                    return Some(frame);
                }
            }
            if let Some(unit) = self.units.pop_front() {
                self.queued_bytes -= bytes_of(&unit);
                // Damage is part of the recording: the same units give the same frames again.
                let _ = self.decoder.decode(&unit, &mut |frame| self.decoded.push_back(frame));
            } else if !std::mem::replace(&mut self.ended, true) {
                // At the end, the decoder releases the pictures that it held back.
                self.decoder.finish(&mut |frame| self.decoded.push_back(frame));
            } else {
                return None;
            }
        }
    }
}

/// A picture that is not that of the run, by its checksum.
#[derive(Debug, thiserror::Error)]
#[error("video frame {sequence} decodes to another picture than in the recorded run")]
pub struct OtherPicture {
    sequence: u64,
}

/// The memory of a queued unit, bytes.
fn bytes_of(unit: &EncodedUnit) -> usize {
    size_of::<EncodedUnit>() + unit.payload.len()
}
