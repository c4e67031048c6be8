//! Decodes encoded units to video frames.
//!
//! A [`UnitDecoder`] has no thread and no clock: the same units give the same frames with the same sequence numbers, live
//! and in a replay.
//!
//! Only intact pictures are delivered. The decoder's own concealment of errors is off, and after damage, or at the start
//! of an epoch, all units up to the next key frame are skipped.
//!
//! In [`DecodeMode::Live`] each unit gives its picture at once. Where the display order differs from the decoding order
//! (B-frames), pictures come with the delay that they need, as soon as the stream announces this or the first B-frame
//! arrives (which may cost the pictures up to the next key frame). In [`DecodeMode::File`] frames always come in display
//! order. The decoder returns pictures in display order, so each picture gets the smallest time that is still pending.
//!
//! Not handled: streams without key frames (periodic intra refresh), which never start; bit errors that leave a slice
//! readable, which an H.264 decoder cannot notice (TCP does, on the way).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, Picture, Plane, VideoFrame};
use openh264::OpenH264API;
use openh264::decoder::{DecodeOptions, DecodedYUV, Decoder, DecoderConfig, Flush};
use openh264::formats::YUVSource;

use super::annexb::{self, NalKind};
use super::pool::PicturePool;
use super::sps::SequenceParameters;
use super::still::StillDecoder;
use crate::error::DecodeError;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};

/// The priority of the decoder: low latency or all frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DecodeMode {
    /// Each picture as soon as its unit arrives.
    Live,
    /// All pictures, in display order.
    File,
}

/// Decodes the units of one source, one after the other.
pub struct UnitDecoder {
    pool: PicturePool,
    still: StillDecoder,
    h264: Option<Decoder>,
    /// The active sequence parameter set as bytes, and its values.
    sps: Vec<u8>,
    parameters: Option<SequenceParameters>,
    is_awaiting_key: bool,
    /// Whether the display order may differ from the decoding order.
    reorders: bool,
    /// Times of the units whose pictures are still in the decoder.
    pending: BinaryHeap<Reverse<Pending>>,
    epoch: Option<u32>,
    delivered: u64,
}

/// The properties of a unit that its picture needs, ordered by display time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Pending {
    at: Timestamp,
    /// Pictures that an edit list hides before the start of the video have the time 0 too, and come first.
    shown: bool,
    index: u64,
    quality: CaptureQuality,
    rotation: Rotation,
}

impl UnitDecoder {
    /// A decoder without a stream.
    pub fn new(mode: DecodeMode) -> Self {
        Self {
            pool: PicturePool::default(),
            still: StillDecoder::default(),
            h264: None,
            sps: Vec::new(),
            parameters: None,
            is_awaiting_key: true,
            reorders: mode == DecodeMode::File,
            pending: BinaryHeap::new(),
            epoch: None,
            delivered: 0,
        }
    }

    /// Whether units are skipped until the next key frame.
    pub const fn is_awaiting_key(&self) -> bool {
        self.is_awaiting_key
    }

    /// Decodes a unit and passes the frames that are ready to `out`: none or one; at the start of an epoch or at a change
    /// of the size, all frames still in the decoder.
    ///
    /// # Errors
    /// [`DecodeError::Unsupported`] for an unsupported stream, [`DecodeError::Damaged`] for a unit without an intact
    /// picture. After the latter the units up to the next key frame are skipped.
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
        }
        let damaged = |reason: String| DecodeError::Damaged { index: unit.index, reason };
        let picture = match unit.codec {
            UnitCodec::H264AnnexB => return self.decode_h264(unit, out),
            UnitCodec::Jpeg => self.still.jpeg(&unit.payload, &mut self.pool).map_err(damaged)?,
            UnitCodec::Png => self.still.png(&unit.payload, &mut self.pool).map_err(damaged)?,
            UnitCodec::RawYuv420 { size, colour } => {
                let planes = raw_planes(&unit.payload, size).ok_or_else(|| {
                    damaged(format!("{} bytes are not a {size} picture", unit.payload.len()))
                })?;
                self.pool.copy(planes, colour, unit.rotation)
            }
        };
        self.is_awaiting_key = false;
        if unit.shown {
            self.deliver(unit.capture, picture, out);
        }
        Ok(())
    }

    /// Passes the frames still in the decoder to `out`, at the end of a video.
    pub fn finish(&mut self, out: &mut impl FnMut(VideoFrame)) {
        self.restart(out);
    }

    fn decode_h264(
        &mut self,
        unit: &EncodedUnit,
        out: &mut impl FnMut(VideoFrame),
    ) -> Result<(), DecodeError> {
        let mut has_picture = false;
        let mut bidirectional = false;
        let mut changed = None;
        for nal in annexb::nals(&unit.payload) {
            match annexb::kind(nal) {
                NalKind::Slice | NalKind::KeySlice => {
                    has_picture = true;
                    bidirectional |= annexb::is_bidirectional(nal);
                }
                NalKind::Sps if nal != self.sps => changed = Some(nal),
                _ => {}
            }
        }
        if let Some(sps) = changed {
            // The decoder loses its pending pictures when the size changes, so they are flushed. A flushed decoder keeps
            // some of its memory, so a new one continues.
            self.flush(out);
            self.pending.clear();
            self.h264 = None;
            let parameters = SequenceParameters::parse(sps)?;
            self.reorders |= parameters.reorders;
            self.parameters = Some(parameters);
            self.sps = sps.to_vec();
        }
        if self.is_awaiting_key && !unit.key {
            return Ok(());
        }
        self.reorders |= bidirectional;
        if has_picture {
            self.pending.push(Reverse(Pending::from_unit(unit)));
        }
        let flush = if self.reorders { Flush::NoFlush } else { Flush::Flush };
        let decoder = match &mut self.h264 {
            Some(decoder) => decoder,
            empty => empty.insert(new_decoder()?),
        };
        let options = DecodeOptions::new().flush_after_decode(flush);
        let damage = match decoder.decode_with_options(&unit.payload, options) {
            Ok(None) => None,
            Ok(Some(yuv)) => {
                let frame = take_picture(&yuv, &mut self.pending, self.parameters, &mut self.pool);
                self.is_awaiting_key = false;
                if let Some((capture, picture)) = frame {
                    self.deliver(capture, picture, out);
                }
                return Ok(());
            }
            Err(error) => Some(error.to_string()),
        };
        match damage {
            None if self.reorders || !has_picture => {
                self.is_awaiting_key &= !has_picture;
                Ok(())
            }
            damage => {
                let reason = damage.unwrap_or_else(|| "it gives no picture".to_owned());
                self.pending.retain(|pending| pending.0.index != unit.index);
                self.restart(out);
                Err(DecodeError::Damaged { index: unit.index, reason })
            }
        }
    }

    /// Delivers the pending frames, then discards the decoder's state and waits for a key frame.
    fn restart(&mut self, out: &mut impl FnMut(VideoFrame)) {
        self.flush(out);
        self.pending.clear();
        self.h264 = None;
        self.is_awaiting_key = true;
    }

    fn flush(&mut self, out: &mut impl FnMut(VideoFrame)) {
        let Some(decoder) = &mut self.h264 else { return };
        // A decoder that fails here has no pending pictures.
        let Ok(pictures) = decoder.flush_remaining() else { return };
        for yuv in pictures {
            if let Some((capture, picture)) =
                take_picture(&yuv, &mut self.pending, self.parameters, &mut self.pool)
            {
                out(VideoFrame { sequence: self.delivered, capture, picture });
                self.delivered += 1;
            }
        }
    }

    fn deliver(&mut self, capture: Capture, picture: Arc<Picture>, out: &mut impl FnMut(VideoFrame)) {
        out(VideoFrame { sequence: self.delivered, capture, picture });
        self.delivered += 1;
    }
}

impl Pending {
    fn from_unit(unit: &EncodedUnit) -> Self {
        let Capture { at, quality } = unit.capture;
        Self { at, index: unit.index, quality, shown: unit.shown, rotation: unit.rotation }
    }
}

fn new_decoder() -> Result<Decoder, DecodeError> {
    Decoder::with_api_config(OpenH264API::from_source(), DecoderConfig::new())
        .map_err(|error| DecodeError::NoDecoder(error.to_string()))
}

/// Copies a decoded picture out of the decoder and pairs it with the smallest pending time. `None` for a picture that is
/// not shown.
fn take_picture(
    yuv: &DecodedYUV<'_>,
    pending: &mut BinaryHeap<Reverse<Pending>>,
    parameters: Option<SequenceParameters>,
    pool: &mut PicturePool,
) -> Option<(Capture, Arc<Picture>)> {
    let Reverse(unit) = pending.pop()?;
    if !unit.shown {
        return None;
    }
    let (width, height) = yuv.dimensions();
    let (y_stride, u_stride, v_stride) = yuv.strides();
    let plane = |data, width, height, stride| Plane { data, width, height, stride };
    let planes = [
        plane(yuv.y(), width, height, y_stride),
        plane(yuv.u(), width.div_ceil(2), height.div_ceil(2), u_stride),
        plane(yuv.v(), width.div_ceil(2), height.div_ceil(2), v_stride),
    ];
    let size = PictureSize::new(width as u32, height as u32);
    let colour = parameters.map_or_else(|| ColourEncoding::assumed_for(size), |parameters| parameters.colour);
    let picture = pool.copy(planes, colour, unit.rotation);
    Some((Capture { at: unit.at, quality: unit.quality }, picture))
}

fn raw_planes(payload: &[u8], size: PictureSize) -> Option<[Plane<'_>; 3]> {
    let chroma = PictureSize::new(size.width.div_ceil(2), size.height.div_ceil(2));
    if payload.len() != size.area() + 2 * chroma.area() {
        return None;
    }
    let (y, uv) = payload.split_at(size.area());
    let (u, v) = uv.split_at(chroma.area());
    let plane = |data, size: PictureSize| {
        let (width, height) = (size.width as usize, size.height as usize);
        Plane { data, width, height, stride: width }
    };
    Some([plane(y, size), plane(u, chroma), plane(v, chroma)])
}
