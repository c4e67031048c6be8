//! The video of a recording, decoded when a step asks for its frame.
//!
//! A recording may hold any number of units that no step asks for, and a small unit may be a large picture. So units wait
//! encoded, up to a stated number of bytes, and are decoded in order until the frame that is asked for comes. Decoded
//! frames wait only where one unit gives several: what the decoder held back, sixteen at most.

use std::collections::VecDeque;

use anyhow::{Result, anyhow, bail};
use barrelman_trial::records::FrameFingerprint;
use barrelman_vocab::{EncodedUnit, VideoFrame};

use barrelman_video::decoder::{DecodeMode, UnitDecoder};

/// The video of a recording.
pub struct StoredVideo {
    decoder: UnitDecoder,
    units: VecDeque<EncodedUnit>,
    /// Bytes of the units that wait.
    waiting_bytes: usize,
    max_waiting_bytes: usize,
    decoded: VecDeque<VideoFrame>,
    ended: bool,
}

impl StoredVideo {
    /// A video of which no unit was read. At most so many bytes of units may wait.
    pub fn new(mode: DecodeMode, max_waiting_bytes: usize) -> Self {
        Self {
            decoder: UnitDecoder::new(mode),
            units: VecDeque::new(),
            waiting_bytes: 0,
            max_waiting_bytes,
            decoded: VecDeque::new(),
            ended: false,
        }
    }

    /// Takes the next unit.
    ///
    /// # Errors
    /// If too many bytes wait to be asked for.
    pub fn add(&mut self, unit: EncodedUnit) -> Result<()> {
        self.waiting_bytes += bytes_of(&unit);
        if self.waiting_bytes > self.max_waiting_bytes {
            bail!(
                "its video runs too far ahead of its steps: up to picture {}, more than {} MiB wait for a step that takes \
                 them; `barrelman export` gives its video",
                unit.index,
                self.max_waiting_bytes >> 20
            );
        }
        self.units.push_back(unit);
        Ok(())
    }

    /// The frame of a stamp, with the time of capture that it had then.
    ///
    /// # Errors
    /// If the units so far do not give this frame, or not the same picture as then.
    pub fn frame(&mut self, stamp: &FrameFingerprint) -> Result<VideoFrame> {
        let mut frame = self
            .next_from(stamp.sequence)
            .filter(|frame| frame.sequence == stamp.sequence)
            .ok_or_else(|| anyhow!("video frame {} is not in the recording", stamp.sequence))?;
        if FrameFingerprint::from_frame(&frame).luma_hash != stamp.luma_hash {
            bail!("video frame {} decodes to another picture than it did then", stamp.sequence);
        }
        frame.capture = stamp.capture;
        Ok(frame)
    }

    /// The next frame that has this number or a higher one.
    fn next_from(&mut self, sequence: u64) -> Option<VideoFrame> {
        loop {
            while let Some(frame) = self.decoded.pop_front() {
                if frame.sequence >= sequence {
                    return Some(frame);
                }
            }
            if let Some(unit) = self.units.pop_front() {
                self.waiting_bytes -= bytes_of(&unit);
                // What was damaged then is damaged now: the frames that came of it are the same.
                let _ = self.decoder.decode(&unit, &mut |frame| self.decoded.push_back(frame));
            } else if !std::mem::replace(&mut self.ended, true) {
                // The last pictures of a file come out when nothing more goes in.
                self.decoder.finish(&mut |frame| self.decoded.push_back(frame));
            } else {
                return None;
            }
        }
    }
}

fn bytes_of(unit: &EncodedUnit) -> usize {
    size_of::<EncodedUnit>() + unit.payload.len()
}
