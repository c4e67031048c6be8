//! Writes MP4 files from pictures, which are encoded, or from access units, which are copied.
//!
//! A file that is not finished (see [`Mp4Writer::finish`]) has no index and cannot be played.

use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use barrelman_vocab::time::Timestamp;
use barrelman_vocab::video::Picture;

use super::muxer::{Mp4Muxer, TrackFormat};
use crate::codec::annexb::{self, NalKind};
use crate::codec::encoder::{EncoderSettings, H264Encoder};
use crate::codec::sps::SequenceParameters;
use crate::error::VideoError;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};

/// Writes one MP4 file with H.264.
pub struct Mp4Writer<W: Write + Seek> {
    path: PathBuf,
    settings: EncoderSettings,
    encoder: H264Encoder,
    state: State<W>,
    epoch: Option<u32>,
}

enum State<W: Write + Seek> {
    /// Nothing was written yet: the first key frame brings the parameters of the track.
    Empty(BufWriter<W>),
    Writing(Box<Mp4Muxer<BufWriter<W>>>),
    /// An earlier write failed: nothing more is written.
    Failed,
}

impl<W: Write + Seek> Mp4Writer<W> {
    /// Writes to `out`, which must be empty. Nothing is written before the first key frame. Errors name
    /// `path`.
    pub fn new(out: W, path: &Path, settings: EncoderSettings) -> Self {
        Self {
            path: path.to_owned(),
            settings,
            encoder: H264Encoder::new(settings),
            state: State::Empty(BufWriter::new(out)),
            epoch: None,
        }
    }

    /// Encodes a picture that was captured at `at` and appends it. The video starts with the first picture.
    ///
    /// # Errors
    /// A size that cannot be encoded, or a file that cannot be written (a full disk).
    pub fn write_picture(&mut self, picture: &Picture, at: Timestamp) -> Result<(), VideoError> {
        let encoded = self.encoder.encode(picture, at)?;
        self.append(&encoded.bytes, encoded.key, at, Rotation::None)
    }

    /// Appends an access unit unchanged. Units before the first key frame of an epoch cannot be decoded and
    /// are left out.
    ///
    /// # Errors
    /// A unit that is not H.264, an unsupported stream, or a file that cannot be written (a full disk).
    pub fn write_unit(&mut self, unit: &EncodedUnit) -> Result<(), VideoError> {
        if unit.codec != UnitCodec::H264AnnexB {
            return Err(VideoError::Unsupported {
                path: self.path.clone(),
                what: "an MP4 file with units other than H.264".to_owned(),
                remedy: "Decode the units and write the pictures".to_owned(),
            });
        }
        if self.epoch != Some(unit.epoch) {
            if !unit.key {
                return Ok(());
            }
            self.epoch = Some(unit.epoch);
        }
        self.append(&unit.payload, unit.key, unit.capture.at, unit.rotation)
    }

    /// Writes the index and closes the file.
    ///
    /// # Errors
    /// A file without a picture, or a file that cannot be written (a full disk).
    pub fn finish(mut self) -> Result<(), VideoError> {
        let frame = Duration::try_from_secs_f64(1.0 / self.settings.fps).unwrap_or_default();
        let result = match std::mem::replace(&mut self.state, State::Failed) {
            State::Writing(muxer) => muxer.finish(frame).map(drop),
            State::Empty(_) => Err(io::Error::other("no picture was given")),
            State::Failed => Err(io::Error::other("writing failed before")),
        };
        result.map_err(|source| self.cannot_write(source))
    }

    fn append(
        &mut self,
        bytes: &[u8],
        key: bool,
        at: Timestamp,
        rotation: Rotation,
    ) -> Result<(), VideoError> {
        self.state = match std::mem::replace(&mut self.state, State::Failed) {
            State::Empty(out) => match track_format(bytes, rotation, &self.path)? {
                Some(format) if key => {
                    let muxer = Mp4Muxer::new(out, format).map_err(|source| self.cannot_write(source))?;
                    State::Writing(Box::new(muxer))
                }
                _ => {
                    self.state = State::Empty(out);
                    return Ok(());
                }
            },
            State::Failed => return Err(self.cannot_write(io::Error::other("writing failed before"))),
            writing => writing,
        };
        let result = match &mut self.state {
            State::Writing(muxer) => muxer.push(bytes, key, at),
            State::Empty(_) | State::Failed => Ok(()),
        };
        result.map_err(|source| {
            self.state = State::Failed;
            self.cannot_write(source)
        })
    }

    fn cannot_write(&self, source: io::Error) -> VideoError {
        VideoError::Io { doing: "write", path: self.path.clone(), cause: source }
    }
}

/// Whether units like this key frame can be written unchanged: H.264 whose parameter sets are read here.
/// Pictures of other units are encoded anew.
pub fn takes_units_like(unit: &EncodedUnit) -> bool {
    unit.codec == UnitCodec::H264AnnexB && track_format(&unit.payload, unit.rotation, Path::new("")).is_ok()
}

/// The properties of the track, from the parameter sets of a key frame; `None` without parameter sets.
fn track_format(unit: &[u8], rotation: Rotation, path: &Path) -> Result<Option<TrackFormat>, VideoError> {
    let find = |kind| annexb::nals(unit).find(|nal| annexb::kind(nal) == kind);
    let Some((sps, pps)) = find(NalKind::Sps).zip(find(NalKind::Pps)) else { return Ok(None) };
    let address = path.display().to_string();
    let parameters = SequenceParameters::parse(sps).map_err(|cause| VideoError::Decode { address, cause })?;
    Ok(Some(TrackFormat { size: parameters.size, rotation, sps: sps.to_vec(), pps: pps.to_vec() }))
}
