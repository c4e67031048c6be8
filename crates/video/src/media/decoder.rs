//! Decodes the units of one stream in a process `barrelman-media`.
//!
//! Each unit is sent, and the pictures that come before the answer are delivered: with a decoder in software
//! that is every picture that is ready. A process that does not answer is ended, and the next key frame
//! starts another.

use std::sync::Arc;
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::ChannelError;
use barrelman_media_protocol::decoder::{DecodedPicture, FromDecoder, ToDecoder};
use barrelman_media_protocol::role::{DecoderSettings, Role};
use barrelman_vocab::unit::{EncodedUnit, Rotation};
use barrelman_vocab::video::{Capture, Picture, Plane};

use super::process::{MediaProcess, MediaProgram, START_TIMEOUT};
use crate::codec::pending::Pending;
use crate::codec::pool::PicturePool;
use crate::error::DecodeError;

/// Longest time to decode a unit of live video: 30 pictures.
const LIVE_ANSWER_TIMEOUT: Duration = Duration::from_secs(1);

/// The same for a file, which nobody waits for: a large picture on a busy machine takes its time.
const FILE_ANSWER_TIMEOUT: Duration = Duration::from_secs(30);

/// Maximum number of units whose pictures are still in the decoder. No format holds back more than 16
/// pictures.
const MAX_PENDING: usize = 64;

/// Receives a picture with its time of capture.
pub(crate) type PictureOut<'a> = dyn FnMut(Capture, Arc<Picture>) + 'a;

/// Decodes one format. Starts its process with the first key frame.
#[derive(Debug)]
pub(crate) struct MediaDecoder {
    program: MediaProgram,
    settings: DecoderSettings,
    process: Option<MediaProcess>,
    pending: Vec<Pending>,
    samples: Vec<u8>,
    has_told_scaling: bool,
}

/// Why a message was not answered.
enum Failure {
    /// The process cannot be used any more.
    Channel(ChannelError),
    /// No decoder of the format.
    NoDecoder { reason: String, remedy: String },
}

impl From<ChannelError> for Failure {
    fn from(error: ChannelError) -> Self {
        Self::Channel(error)
    }
}

impl MediaDecoder {
    pub(crate) const fn new(program: MediaProgram, settings: DecoderSettings) -> Self {
        Self {
            program,
            settings,
            process: None,
            pending: Vec::new(),
            samples: Vec::new(),
            has_told_scaling: false,
        }
    }

    pub(crate) const fn settings(&self) -> DecoderSettings {
        self.settings
    }

    /// Decodes a unit. `is_start`: decoding starts with it.
    ///
    /// # Errors
    /// [`DecodeError::Damaged`]: nothing that follows can be decoded up to the next key frame. Other errors:
    /// the format cannot be decoded.
    pub(crate) fn decode(
        &mut self,
        unit: &EncodedUnit,
        is_start: bool,
        pool: &mut PicturePool,
        out: &mut PictureOut<'_>,
    ) -> Result<(), DecodeError> {
        self.start()?;
        if self.pending.len() >= MAX_PENDING {
            self.pending.remove(0);
        }
        self.pending.push(Pending::from_unit(unit));
        let message = ToDecoder::Decode { pts_ns: unit.capture.at.as_nanos(), key: is_start };
        let damage = self.exchange(&message, &unit.payload, pool, out)?;
        match damage {
            None => Ok(()),
            Some(reason) => Err(DecodeError::Damaged { index: unit.index, reason }),
        }
    }

    /// Delivers the pictures that are still in the decoder, and forgets the stream. Never fails: a decoder
    /// that does not answer has no pictures.
    pub(crate) fn flush(&mut self, pool: &mut PicturePool, out: &mut PictureOut<'_>) {
        if self.process.is_some() && !self.pending.is_empty() {
            let _ = self.exchange(&ToDecoder::Flush, &[], pool, out);
        }
        self.pending.clear();
    }

    fn start(&mut self) -> Result<(), DecodeError> {
        if self.process.is_some() {
            return Ok(());
        }
        let no_decoder =
            |reason: String| DecodeError::NoDecoder { format: self.settings.format.name(), reason };
        let role = Role::Decoder(self.settings);
        let mut process =
            MediaProcess::start(&self.program, role).map_err(|error| no_decoder(error.to_string()))?;
        match process.channel().receive::<FromDecoder>(Instant::now() + START_TIMEOUT) {
            Ok(Some((FromDecoder::Ready { element, .. }, 0))) => {
                tracing::debug!("{} is decoded by {element}", self.settings.format.name());
                self.process = Some(process);
                Ok(())
            }
            Ok(Some((FromDecoder::NoDecoder { reason, remedy }, 0))) => {
                Err(no_decoder(format!("{reason}. {remedy}")))
            }
            Ok(Some(_)) => Err(no_decoder(process.end(&ChannelError::Malformed))),
            Ok(None) => Err(no_decoder("it does not start".to_owned())),
            Err(error) => Err(no_decoder(process.end(&error))),
        }
    }

    /// Sends a message and delivers pictures until it is answered. Returns the damage that the answer tells.
    fn exchange(
        &mut self,
        message: &ToDecoder,
        payload: &[u8],
        pool: &mut PicturePool,
        out: &mut PictureOut<'_>,
    ) -> Result<Option<String>, DecodeError> {
        let Some(mut process) = self.process.take() else { return Ok(None) };
        let index = self.pending.last().map_or(0, |pending| pending.index);
        match self.converse(&mut process, message, payload, pool, out) {
            Ok(damage) => {
                self.process = Some(process);
                Ok(damage)
            }
            Err(Failure::Channel(error)) => {
                self.pending.clear();
                Err(DecodeError::Damaged { index, reason: process.end(&error) })
            }
            Err(Failure::NoDecoder { reason, remedy }) => Err(DecodeError::NoDecoder {
                format: self.settings.format.name(),
                reason: format!("{reason}. {remedy}"),
            }),
        }
    }

    fn converse(
        &mut self,
        process: &mut MediaProcess,
        message: &ToDecoder,
        payload: &[u8],
        pool: &mut PicturePool,
        out: &mut PictureOut<'_>,
    ) -> Result<Option<String>, Failure> {
        process.send(message, payload)?;
        let timeout = if self.settings.is_live { LIVE_ANSWER_TIMEOUT } else { FILE_ANSWER_TIMEOUT };
        let deadline = Instant::now() + timeout;
        loop {
            let Some((answer, length)) = process.channel().receive(deadline)? else {
                return Err(Failure::Channel(ChannelError::Stopped));
            };
            match answer {
                FromDecoder::Picture(decoded) => {
                    let (pending, picture) = self.receive_picture(process, decoded, length, pool)?;
                    if pending.shown {
                        out(pending.capture(), picture);
                    }
                }
                FromDecoder::Done { damage } if length == 0 => return Ok(damage),
                FromDecoder::NoDecoder { reason, remedy } if length == 0 => {
                    return Err(Failure::NoDecoder { reason, remedy });
                }
                FromDecoder::Done { .. } | FromDecoder::NoDecoder { .. } | FromDecoder::Ready { .. } => {
                    return Err(Failure::Channel(ChannelError::Malformed));
                }
            }
        }
    }

    /// Reads a picture, and finds the unit that it was decoded from: the one with its time, else the
    /// earliest.
    fn receive_picture(
        &mut self,
        process: &mut MediaProcess,
        decoded: DecodedPicture,
        length: usize,
        pool: &mut PicturePool,
    ) -> Result<(Pending, Arc<Picture>), ChannelError> {
        let size = decoded.size;
        let chroma = barrelman_vocab::PictureSize::new(size.width.div_ceil(2), size.height.div_ceil(2));
        let max_side = barrelman_media_protocol::decoder::MAX_SIDE;
        if size.width.max(size.height) > max_side || length != size.area() + 2 * chroma.area() || length == 0
        {
            return Err(ChannelError::Malformed);
        }
        if let (Some(from), false) = (decoded.scaled_from, self.has_told_scaling) {
            self.has_told_scaling = true;
            tracing::info!(
                "the pictures of {from} are scaled down to {size}: {max_side} pixels a side are read"
            );
        }
        let with_its_time = self.pending.iter().position(|unit| unit.at.as_nanos() == decoded.pts_ns);
        let earliest = || self.pending.iter().enumerate().min_by_key(|(_, unit)| **unit).map(|(at, _)| at);
        let at = with_its_time.or_else(earliest).ok_or(ChannelError::Malformed)?;
        let pending = self.pending.remove(at);
        let picture = match pending.rotation {
            Rotation::None => pool.fill(size, decoded.colour, |picture| {
                let planes = picture.planes_mut();
                planes.into_iter().try_for_each(|samples| process.channel().read_payload(samples))
            })?,
            rotation => {
                self.samples.resize(length, 0);
                process.channel().read_payload(&mut self.samples)?;
                let planes = Plane::split_yuv420(&self.samples, size).ok_or(ChannelError::Malformed)?;
                pool.copy(planes, decoded.colour, rotation)
            }
        };
        Ok((pending, picture))
    }
}
