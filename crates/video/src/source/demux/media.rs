//! Reads files of any kind that GStreamer knows, in a process `barrelman-media`.

use std::time::Instant;

use barrelman_media_protocol::channel::ChannelError;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::source::{FromSource, SourceSettings, SourceUnit, UnitTime};
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::{Capture, CaptureQuality};
use bytes::Bytes;

use super::stamp::capture_at;
use crate::error::VideoError;
use crate::media::MediaProgram;
use crate::media::process::{MediaProcess, START_TIMEOUT};

/// Pictures per second that are assumed where a file has no times.
const ASSUMED_FPS: u64 = 30;

/// Reads the units of one file.
pub struct MediaReader {
    process: MediaProcess,
    address: String,
    epoch: u32,
    next: u64,
    ended: bool,
}

impl MediaReader {
    /// Opens a file.
    ///
    /// # Errors
    /// A file that GStreamer does not read.
    pub(in crate::source) fn open(
        program: &MediaProgram,
        settings: SourceSettings,
        address: String,
    ) -> Result<Self, VideoError> {
        let process = MediaProcess::start(program, Role::Source(settings))?;
        let mut reader = Self { process, address, epoch: 0, next: 0, ended: false };
        loop {
            let (message, payload) = reader.receive()?;
            match message {
                FromSource::Opened(what) => {
                    tracing::debug!("{}: {what}", reader.address);
                    return Ok(reader);
                }
                other => {
                    reader.unit_of(other, payload)?;
                    if reader.ended {
                        return Err(reader.unusable("holds no video", "Give a file with video"));
                    }
                }
            }
        }
    }

    /// The next unit, or `None` at the end.
    ///
    /// # Errors
    /// Damage that ends the file early, or a process that has ended.
    pub fn next_unit(&mut self) -> Result<Option<EncodedUnit>, VideoError> {
        while !self.ended {
            let (message, payload) = self.receive()?;
            if let Some(unit) = self.unit_of(message, payload)? {
                return Ok(Some(unit));
            }
        }
        Ok(None)
    }

    fn receive(&mut self) -> Result<(FromSource, Vec<u8>), VideoError> {
        match self.process.receive(Instant::now() + START_TIMEOUT) {
            Ok(Some(message)) => Ok(message),
            Ok(None) => Err(self.failed(&ChannelError::Stopped)),
            Err(error) => Err(self.failed(&error)),
        }
    }

    /// The unit of a message, if it is one.
    fn unit_of(&mut self, message: FromSource, payload: Vec<u8>) -> Result<Option<EncodedUnit>, VideoError> {
        match message {
            FromSource::Unit(unit) => Ok(Some(self.unit(&unit, payload))),
            FromSource::Note(note) => {
                tracing::warn!("{}: {note}", self.address);
                Ok(None)
            }
            FromSource::Ended => {
                self.ended = true;
                Ok(None)
            }
            FromSource::Failed(failure) => {
                self.ended = true;
                Err(self.unusable(&failure.what, &failure.remedy))
            }
            FromSource::Alive | FromSource::Opened(_) | FromSource::SenderReport(_) => Ok(None),
        }
    }

    fn unit(&mut self, unit: &SourceUnit, payload: Vec<u8>) -> EncodedUnit {
        if unit.follows_loss && !unit.key {
            self.epoch += 1;
        }
        let index = self.next;
        self.next += 1;
        let capture = match unit.time {
            UnitTime::SinceStart(ns) | UnitTime::Captured(ns) => {
                Capture { at: Timestamp::from_nanos(ns), quality: CaptureQuality::Sender }
            }
            UnitTime::Ticks(_) | UnitTime::Unknown => capture_at(index, ASSUMED_FPS),
        };
        EncodedUnit {
            epoch: self.epoch,
            index,
            capture,
            key: unit.key,
            shown: true,
            rotation: unit.rotation,
            codec: unit.codec,
            payload: Bytes::from(payload),
        }
    }

    fn failed(&mut self, error: &ChannelError) -> VideoError {
        self.ended = true;
        let what = format!("cannot be read on: {}", self.process.end(error));
        self.unusable(&what, "Run the command again")
    }

    fn unusable(&self, what: &str, remedy: &str) -> VideoError {
        VideoError::Stream { address: self.address.clone(), what: what.to_owned(), remedy: remedy.to_owned() }
    }
}
