//! The built-in decoder of H.264 (openh264).
//!
//! The decoder's own concealment of errors is off. Where the display order differs from the decoding order
//! (B-frames), pictures come with the delay that they need, as soon as the stream announces this or the first
//! B-frame arrives (which may cost the pictures up to the next key frame). The decoder returns pictures in
//! display order, so each picture gets the smallest time that is still pending.
//!
//! Not handled: streams without key frames (periodic intra refresh), which never start; bit errors that leave
//! a slice readable, which an H.264 decoder cannot notice (TCP does, on the way).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::{Capture, ColourEncoding, Picture, Plane};
use openh264::OpenH264API;
use openh264::decoder::{DecodeOptions, DecodedYUV, Decoder, DecoderConfig, Flush};
use openh264::formats::YUVSource;

use super::annexb::{self, NalKind};
use super::mode::DecodeMode;
use super::pending::Pending;
use super::pool::PicturePool;
use super::sps::SequenceParameters;
use crate::error::DecodeError;
use crate::media::decoder::PictureOut;

/// Decodes one stream.
pub(super) struct H264Decoder {
    decoder: Option<Decoder>,
    /// The active sequence parameter set as bytes, and its values.
    sps: Vec<u8>,
    parameters: Option<SequenceParameters>,
    /// Whether the display order may differ from the decoding order.
    reorders: bool,
    /// Times of the units whose pictures are still in the decoder.
    pending: BinaryHeap<Reverse<Pending>>,
}

impl H264Decoder {
    pub(super) fn new(mode: DecodeMode) -> Self {
        Self {
            decoder: None,
            sps: Vec::new(),
            parameters: None,
            reorders: mode == DecodeMode::File,
            pending: BinaryHeap::new(),
        }
    }

    /// Decodes a unit. `is_awaiting_key`: units up to the next key frame are skipped; cleared by a unit that
    /// is intact.
    ///
    /// # Errors
    /// [`DecodeError::Unsupported`] for an unsupported stream, [`DecodeError::Damaged`] for a unit without an
    /// intact picture.
    pub(super) fn decode(
        &mut self,
        unit: &EncodedUnit,
        is_awaiting_key: &mut bool,
        pool: &mut PicturePool,
        out: &mut PictureOut<'_>,
    ) -> Result<(), DecodeError> {
        let has_picture = self.scan(unit, pool, out)?;
        if *is_awaiting_key && !unit.key {
            return Ok(());
        }
        if has_picture {
            self.pending.push(Reverse(Pending::from_unit(unit)));
        }
        let flush = if self.reorders { Flush::NoFlush } else { Flush::Flush };
        let decoder = match &mut self.decoder {
            Some(decoder) => decoder,
            empty => empty.insert(new_decoder()?),
        };
        let options = DecodeOptions::new().flush_after_decode(flush);
        let damage = match decoder.decode_with_options(&unit.payload, options) {
            Ok(None) => None,
            Ok(Some(yuv)) => {
                let taken = take_picture(&yuv, &mut self.pending, self.parameters, pool);
                *is_awaiting_key = false;
                if let Some((capture, picture)) = taken {
                    out(capture, picture);
                }
                return Ok(());
            }
            Err(error) => Some(error.to_string()),
        };
        match damage {
            None if self.reorders || !has_picture => {
                *is_awaiting_key &= !has_picture;
                Ok(())
            }
            damage => {
                let reason = damage.unwrap_or_else(|| "it gives no picture".to_owned());
                self.pending.retain(|pending| pending.0.index != unit.index);
                Err(DecodeError::Damaged { index: unit.index, reason })
            }
        }
    }

    /// Takes over new parameters, and notes a B-frame. Returns whether the unit has a picture.
    fn scan(
        &mut self,
        unit: &EncodedUnit,
        pool: &mut PicturePool,
        out: &mut PictureOut<'_>,
    ) -> Result<bool, DecodeError> {
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
            // The decoder loses its pending pictures when the size changes, so they are flushed. A flushed
            // decoder keeps some of its memory, so a new one continues.
            self.flush(pool, out);
            let parameters = SequenceParameters::parse(sps)?;
            self.reorders |= parameters.reorders;
            self.parameters = Some(parameters);
            self.sps = sps.to_vec();
        }
        self.reorders |= bidirectional;
        Ok(has_picture)
    }

    /// Delivers the pictures that are still in the decoder, and discards its state.
    pub(super) fn flush(&mut self, pool: &mut PicturePool, out: &mut PictureOut<'_>) {
        // A decoder that fails here has no pending pictures.
        if let Some(decoder) = &mut self.decoder
            && let Ok(pictures) = decoder.flush_remaining()
        {
            for yuv in pictures {
                if let Some((capture, picture)) = take_picture(&yuv, &mut self.pending, self.parameters, pool)
                {
                    out(capture, picture);
                }
            }
        }
        self.pending.clear();
        self.decoder = None;
    }
}

fn new_decoder() -> Result<Decoder, DecodeError> {
    Decoder::with_api_config(OpenH264API::from_source(), DecoderConfig::new())
        .map_err(|error| DecodeError::NoDecoder { format: "H.264", reason: error.to_string() })
}

/// Copies a decoded picture out of the decoder and pairs it with the smallest pending time. `None` for a
/// picture that is not shown.
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
    Some((unit.capture(), picture))
}
