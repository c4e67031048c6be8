//! Encoded units to video frames.
//!
//! A [`UnitDecoder`] is a plain struct without a thread or a clock: the same units give the same frames with the
//! same sequence numbers, live and in a replay.
//!
//! A picture that is not known to be intact is not delivered: the decoder's own concealment of errors is off,
//! and after damage, or at the start of an epoch, everything up to the next key frame is passed over.
//! In [`DecodeMode::Live`] each unit gives its picture at once. Pictures that are shown in another order than
//! they are sent (B-frames) come with the delay that they need, as soon as the stream announces them or the first
//! one is seen (which then may cost the pictures up to the next key frame). In
//! [`DecodeMode::File`] the order of display is always kept. Pictures and times are matched by order: the
//! pictures come out in the order of display, so each gets the smallest time not yet given.
//!
//! Not handled: streams without key frames (periodic intra refresh), which never start; changed bits that leave
//! a slice readable, which no H.264 decoder can notice (TCP does, on the way here).

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
use super::sps::StreamFormat;
use super::still::StillDecoder;
use crate::error::DecodeError;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};

/// What matters more: time or completeness.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DecodeMode {
    /// Each picture as soon as its unit is there.
    Live,
    /// Every picture, in the order of display.
    File,
}

/// Decodes the units of one source, one after the other.
pub struct UnitDecoder {
    pool: PicturePool,
    still: StillDecoder,
    h264: Option<Decoder>,
    /// The sequence parameter set in force, and what it says.
    sps: Vec<u8>,
    format: Option<StreamFormat>,
    waits_for_key: bool,
    reorders: bool,
    /// Times of units whose pictures are still to come.
    pending: BinaryHeap<Reverse<Pending>>,
    epoch: Option<u32>,
    delivered: u64,
}

/// The part of a unit that its picture will need, ordered by time of display.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Pending {
    at: Timestamp,
    /// What an edit list hides before the start of the film has the time 0 too, and comes first.
    shown: bool,
    index: u64,
    quality: CaptureQuality,
    rotation: Rotation,
}

impl UnitDecoder {
    /// A decoder that has seen nothing.
    pub fn new(mode: DecodeMode) -> Self {
        Self {
            pool: PicturePool::default(),
            still: StillDecoder::default(),
            h264: None,
            sps: Vec::new(),
            format: None,
            waits_for_key: true,
            reorders: mode == DecodeMode::File,
            pending: BinaryHeap::new(),
            epoch: None,
            delivered: 0,
        }
    }

    /// Whether units are passed over until the next key frame.
    pub const fn waits_for_key(&self) -> bool {
        self.waits_for_key
    }

    /// Decodes a unit, and hands over the frames that are ready: none or one, and at the start of an epoch, or
    /// where the size changes, all that were held back before it.
    ///
    /// # Errors
    /// [`DecodeError::Unsupported`] for a stream that is not decoded here, [`DecodeError::Damaged`] for a unit
    /// that gives no intact picture. After the latter the units up to the next key frame are passed over.
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
                let planes = raw_planes(&unit.payload, size)
                    .ok_or_else(|| damaged(format!("{} bytes are no {size} picture", unit.payload.len())))?;
                self.pool.copy(planes, colour, unit.rotation)
            }
        };
        self.waits_for_key = false;
        if unit.shown {
            self.deliver(unit.capture, picture, out);
        }
        Ok(())
    }

    /// Hands over the frames that are still held back, at the end of a video.
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
            // What was held back is of the old kind, and the decoder loses it when the size changes. A decoder that
            // was flushed keeps some of its memory for ever, so a new one goes on.
            self.flush(out);
            self.pending.clear();
            self.h264 = None;
            let format = StreamFormat::parse(sps)?;
            self.reorders |= format.reorders;
            self.format = Some(format);
            self.sps = sps.to_vec();
        }
        if self.waits_for_key && !unit.key {
            return Ok(());
        }
        self.reorders |= bidirectional;
        if has_picture {
            self.pending.push(Reverse(Pending::of(unit)));
        }
        let flush = if self.reorders { Flush::NoFlush } else { Flush::Flush };
        let decoder = match &mut self.h264 {
            Some(decoder) => decoder,
            none => none.insert(new_decoder()?),
        };
        let options = DecodeOptions::new().flush_after_decode(flush);
        let damage = match decoder.decode_with_options(&unit.payload, options) {
            Ok(None) => None,
            Ok(Some(yuv)) => {
                let frame = emit(&yuv, &mut self.pending, self.format, &mut self.pool);
                self.waits_for_key = false;
                if let Some((capture, picture)) = frame {
                    self.deliver(capture, picture, out);
                }
                return Ok(());
            }
            Err(error) => Some(error.to_string()),
        };
        match damage {
            None if self.reorders || !has_picture => {
                self.waits_for_key &= !has_picture;
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

    /// Gives up what the decoder refers to, and waits for a key frame.
    fn restart(&mut self, out: &mut impl FnMut(VideoFrame)) {
        self.flush(out);
        self.pending.clear();
        self.h264 = None;
        self.waits_for_key = true;
    }

    fn flush(&mut self, out: &mut impl FnMut(VideoFrame)) {
        let Some(decoder) = &mut self.h264 else { return };
        // Each picture came of a unit that was decoded without an error; a decoder that fails now has none.
        let Ok(pictures) = decoder.flush_remaining() else { return };
        for yuv in pictures {
            if let Some((capture, picture)) = emit(&yuv, &mut self.pending, self.format, &mut self.pool) {
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
    fn of(unit: &EncodedUnit) -> Self {
        let Capture { at, quality } = unit.capture;
        Self { at, index: unit.index, quality, shown: unit.shown, rotation: unit.rotation }
    }
}

fn new_decoder() -> Result<Decoder, DecodeError> {
    Decoder::with_api_config(OpenH264API::from_source(), DecoderConfig::new())
        .map_err(|error| DecodeError::NoDecoder(error.to_string()))
}

/// Copies a decoded picture out of the decoder, and gives it the smallest time that is not yet given.
fn emit(
    yuv: &DecodedYUV<'_>,
    pending: &mut BinaryHeap<Reverse<Pending>>,
    format: Option<StreamFormat>,
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
    let colour = format.map_or_else(|| ColourEncoding::assumed_for(size), |format| format.colour);
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
