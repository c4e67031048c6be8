//! The video file of an export: H.264 units as received; what an MP4 file of ours does not take is decoded
//! and encoded.

use anyhow::{Result, bail};
use barrelman_host::output::OutputFile;
use barrelman_video::DecodeError;
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::encoder::EncoderSettings;
use barrelman_video::mode::DecodeMode;
use barrelman_video::writer::{Mp4Writer, takes_units_like};
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::{EncodedUnit, PictureSize, Timestamp};

/// The video file of an export.
pub(super) struct VideoFile {
    /// The file, until the first key frame. A video without a key frame is not written.
    file: Option<OutputFile>,
    state: Option<BegunVideo>,
    /// Units without an intact picture, as a live run passes over them, too.
    pub(super) damaged: u64,
}

/// A video from its first key frame on.
struct BegunVideo {
    writer: Mp4Writer<OutputFile>,
    decoder: UnitDecoder,
    /// Whether units are written as received.
    is_copied: bool,
    /// Time of capture of the first unit.
    start: Timestamp,
    is_empty: bool,
}

impl VideoFile {
    pub(super) const fn new(file: OutputFile) -> Self {
        Self { file: Some(file), state: None, damaged: 0 }
    }

    pub(super) fn add(&mut self, unit: &EncodedUnit) -> Result<()> {
        if unit.key
            && let Some(file) = self.file.take()
        {
            self.state = Some(BegunVideo::new(file, unit));
        }
        let Some(video) = &mut self.state else { return Ok(()) };
        if video.is_copied {
            return video.copy(unit);
        }
        match video.decode(unit)? {
            Err(error) if error.is_final() => {
                bail!("picture {} of the video cannot be decoded: {error}", unit.index)
            }
            Err(_) => self.damaged += 1,
            Ok(()) => {}
        }
        Ok(())
    }

    /// Writes the end of the video. Returns whether it has pictures.
    pub(super) fn finish(self) -> Result<bool> {
        self.state.map_or(Ok(false), BegunVideo::finish)
    }
}

impl BegunVideo {
    fn new(file: OutputFile, first: &EncodedUnit) -> Self {
        let path = file.path().to_owned();
        let size = match first.codec {
            UnitCodec::RawYuv420 { size, .. } => size,
            UnitCodec::H264AnnexB
            | UnitCodec::H265AnnexB
            | UnitCodec::Vp9
            | UnitCodec::Av1
            | UnitCodec::Jpeg
            | UnitCodec::Png => PictureSize::new(1280, 720),
        };
        Self {
            writer: Mp4Writer::new(file, &path, EncoderSettings::for_pictures(size, 30.0)),
            decoder: UnitDecoder::new(DecodeMode::File),
            is_copied: takes_units_like(first),
            start: first.capture.at,
            is_empty: true,
        }
    }

    fn copy(&mut self, unit: &EncodedUnit) -> Result<()> {
        let mut unit = unit.clone();
        unit.capture.at = since_start(unit.capture.at, self.start);
        self.is_empty = false;
        Ok(self.writer.write_unit(&unit)?)
    }

    /// Encodes the pictures of a unit anew. The inner result: whether the unit was intact.
    fn decode(&mut self, unit: &EncodedUnit) -> Result<Result<(), DecodeError>> {
        let Self { writer, decoder, start, is_empty, .. } = self;
        let mut written = Ok(());
        let decoded = decoder.decode(unit, &mut |frame| {
            if written.is_ok() {
                *is_empty = false;
                written = writer.write_picture(&frame.picture, since_start(frame.capture.at, *start));
            }
        });
        written?;
        Ok(decoded)
    }

    /// Writes what the decoder held back, and the file's index. Returns whether the video has pictures.
    fn finish(mut self) -> Result<bool> {
        let Self { writer, decoder, start, is_empty, .. } = &mut self;
        let mut written = Ok(());
        decoder.finish(&mut |frame| {
            if written.is_ok() {
                *is_empty = false;
                written = writer.write_picture(&frame.picture, since_start(frame.capture.at, *start));
            }
        });
        written?;
        if !self.is_empty {
            self.writer.finish()?;
        }
        Ok(!self.is_empty)
    }
}

fn since_start(at: Timestamp, start: Timestamp) -> Timestamp {
    Timestamp::ZERO.plus(at.since(start))
}
