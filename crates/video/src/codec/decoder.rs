//! Decodes encoded units to video frames.
//!
//! A [`UnitDecoder`] has no clock: the same units give the same frames with the same sequence numbers, live
//! and in a replay. H.264, JPEG, PNG and uncompressed pictures are decoded in this process. Other formats,
//! and H.264 that the built-in decoder does not read (interlaced, more than 8 bits, other chroma than 4:2:0,
//! no IDR pictures), are decoded by GStreamer in another process ([`crate::media`]). The content of the units
//! decides which, so that a replay decides the same.
//!
//! Only intact pictures are delivered: after damage, or at the start of an epoch, all units up to the next
//! key frame are skipped.
//!
//! In [`DecodeMode::Live`] each unit gives its picture at once, unless the display order differs from the
//! decoding order. In [`DecodeMode::File`] frames always come in display order.

use std::sync::Arc;
use std::time::Duration;

use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::DecoderSettings;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, Picture, Plane, VideoFrame};

use super::annexb;
use super::h264::H264Decoder;
use super::mode::DecodeMode;
use super::pool::PicturePool;
use super::still::StillDecoder;
use crate::engine::VideoEngine;
use crate::error::DecodeError;
use crate::media::MediaProgram;
use crate::media::decoder::MediaDecoder;

/// H.264 without a key frame for this long is decoded from a recovery point on.
const MAX_WAIT_FOR_KEY: Duration = Duration::from_secs(2);

/// Decodes the units of one source, one after the other.
pub struct UnitDecoder {
    mode: DecodeMode,
    engine: VideoEngine,
    pool: PicturePool,
    still: StillDecoder,
    h264: H264Decoder,
    media: Option<MediaDecoder>,
    /// Whether the H.264 of this epoch is decoded by GStreamer.
    h264_by_media: bool,
    is_awaiting_key: bool,
    /// Time of the first unit that was skipped in this epoch.
    skipped_since: Option<Timestamp>,
    epoch: Option<u32>,
    delivered: u64,
}

impl UnitDecoder {
    /// A decoder without a stream.
    pub fn new(mode: DecodeMode) -> Self {
        Self::with_engine(mode, VideoEngine::Auto)
    }

    /// A decoder by this engine.
    pub fn with_engine(mode: DecodeMode, engine: VideoEngine) -> Self {
        Self {
            mode,
            engine,
            pool: PicturePool::default(),
            still: StillDecoder::default(),
            h264: H264Decoder::new(mode),
            media: None,
            h264_by_media: engine == VideoEngine::Gstreamer,
            is_awaiting_key: true,
            skipped_since: None,
            epoch: None,
            delivered: 0,
        }
    }

    /// Whether units are skipped until the next key frame.
    pub const fn is_awaiting_key(&self) -> bool {
        self.is_awaiting_key
    }

    /// Decodes a unit and passes the frames that are ready to `out`: none or one; at the start of an epoch or
    /// at a change of the size, all frames still in the decoder.
    ///
    /// # Errors
    /// [`DecodeError::Unsupported`] for an unsupported stream, [`DecodeError::Damaged`] for a unit without an
    /// intact picture. After the latter the units up to the next key frame are skipped.
    pub fn decode(
        &mut self,
        unit: &EncodedUnit,
        out: &mut impl FnMut(VideoFrame),
    ) -> Result<(), DecodeError> {
        if self.epoch != Some(unit.epoch) {
            if self.epoch.is_some() {
                self.restart(out);
            }
            self.epoch = Some(unit.epoch);
            self.h264_by_media = self.engine == VideoEngine::Gstreamer;
            self.skipped_since = None;
        }
        let damaged = |reason: String| DecodeError::Damaged { index: unit.index, reason };
        let picture = match unit.codec {
            UnitCodec::H264AnnexB => return self.decode_h264(unit, out),
            UnitCodec::H265AnnexB => return self.decode_by_media(CodedFormat::H265, unit, out),
            UnitCodec::Vp9 => return self.decode_by_media(CodedFormat::Vp9, unit, out),
            UnitCodec::Av1 => return self.decode_by_media(CodedFormat::Av1, unit, out),
            UnitCodec::Jpeg => self.still.jpeg(&unit.payload, &mut self.pool).map_err(damaged)?,
            UnitCodec::Png => self.still.png(&unit.payload, &mut self.pool).map_err(damaged)?,
            UnitCodec::RawYuv420 { size, colour } => {
                let planes = Plane::split_yuv420(&unit.payload, size).ok_or_else(|| {
                    damaged(format!("{} bytes are not a {size} picture", unit.payload.len()))
                })?;
                self.pool.copy(planes, colour, unit.rotation)
            }
        };
        self.is_awaiting_key = false;
        if unit.shown {
            let picture = match (unit.codec, unit.rotation) {
                (UnitCodec::RawYuv420 { .. }, _) | (_, Rotation::None) => picture,
                (_, rotation) => {
                    let planes = [picture.y(), picture.u(), picture.v()];
                    self.pool.copy(planes, picture.colour(), rotation)
                }
            };
            deliver(&mut self.delivered, unit.capture, picture, out);
        }
        Ok(())
    }

    /// Passes the frames still in the decoder to `out`, at the end of a video.
    pub fn finish(&mut self, out: &mut impl FnMut(VideoFrame)) {
        self.restart(out);
    }

    /// Decodes H.264 by the built-in decoder, and from where that cannot go on, by GStreamer.
    fn decode_h264(
        &mut self,
        unit: &EncodedUnit,
        out: &mut impl FnMut(VideoFrame),
    ) -> Result<(), DecodeError> {
        if !self.h264_by_media && (self.begins_without_idr(unit) || self.waits_in_vain(unit)) {
            self.h264_by_media = self.can_change_over();
        }
        if self.h264_by_media {
            return self.decode_by_media(CodedFormat::H264, unit, out);
        }
        let Self { h264, is_awaiting_key, pool, delivered, .. } = self;
        let mut deliver = |capture, picture| deliver(delivered, capture, picture, out);
        match h264.decode(unit, is_awaiting_key, pool, &mut deliver) {
            Ok(()) => Ok(()),
            Err(DecodeError::Unsupported { .. }) if self.can_change_over() => {
                self.h264_by_media = true;
                self.decode_by_media(CodedFormat::H264, unit, out)
            }
            Err(error) => {
                self.restart(out);
                Err(error)
            }
        }
    }

    /// Whether decoding begins at a unit of H.264 that is no IDR picture: at a recovery point, or at an intra
    /// picture of an open group of pictures. The built-in decoder begins at IDR pictures only.
    fn begins_without_idr(&self, unit: &EncodedUnit) -> bool {
        self.is_awaiting_key && unit.key && annexb::lacks_key_slice(&unit.payload)
    }

    /// Whether a unit of H.264 has a recovery point, and units have been skipped for longer than cameras send
    /// no key frame.
    fn waits_in_vain(&mut self, unit: &EncodedUnit) -> bool {
        if !self.is_awaiting_key || unit.key {
            self.skipped_since = None;
            return false;
        }
        let since = *self.skipped_since.get_or_insert(unit.capture.at);
        unit.capture.at.since(since) >= MAX_WAIT_FOR_KEY && annexb::has_recovery_point(&unit.payload)
    }

    fn can_change_over(&self) -> bool {
        self.engine.media_program().is_some()
    }

    fn decode_by_media(
        &mut self,
        format: CodedFormat,
        unit: &EncodedUnit,
        out: &mut impl FnMut(VideoFrame),
    ) -> Result<(), DecodeError> {
        let is_start = unit.key
            || (format == CodedFormat::H264
                && self.is_awaiting_key
                && annexb::has_recovery_point(&unit.payload));
        if self.is_awaiting_key && !is_start {
            return Ok(());
        }
        if self.media.as_ref().is_none_or(|media| media.settings().format != format) {
            self.restart(out);
            let settings = DecoderSettings { format, is_live: self.mode == DecodeMode::Live };
            self.media = Some(self.new_media_decoder(settings)?);
        }
        let Self { media: Some(media), pool, delivered, .. } = self else { return Ok(()) };
        let mut deliver = |capture, picture| deliver(delivered, capture, picture, out);
        let result = media.decode(unit, is_start, pool, &mut deliver);
        match result {
            Ok(()) => self.is_awaiting_key = false,
            Err(_) => self.restart(out),
        }
        result
    }

    fn new_media_decoder(&self, settings: DecoderSettings) -> Result<MediaDecoder, DecodeError> {
        let what = || settings.format.name().to_owned();
        if self.engine == VideoEngine::BuiltIn {
            let remedy = "Set video.engine = \"auto\", or set the camera to H.264".to_owned();
            return Err(DecodeError::Unsupported { what: what(), remedy });
        }
        let program = self.engine.media_program().ok_or_else(|| DecodeError::Unsupported {
            what: what(),
            remedy: format!("barrelman-media decodes it: {}", MediaProgram::INSTALLATION),
        })?;
        Ok(MediaDecoder::new(program, settings))
    }

    /// Delivers the pending frames, then discards the decoders' states and waits for a key frame.
    fn restart(&mut self, out: &mut impl FnMut(VideoFrame)) {
        let Self { h264, media, pool, delivered, .. } = self;
        let mut deliver = |capture, picture| deliver(delivered, capture, picture, out);
        h264.flush(pool, &mut deliver);
        if let Some(media) = media {
            media.flush(pool, &mut deliver);
        }
        self.is_awaiting_key = true;
    }
}

fn deliver(delivered: &mut u64, capture: Capture, picture: Arc<Picture>, out: &mut impl FnMut(VideoFrame)) {
    out(VideoFrame { sequence: *delivered, capture, picture });
    *delivered += 1;
}
