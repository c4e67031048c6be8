//! A camera whose pictures are encoded as H.264 and decoded again before the pilot receives them.
//!
//! A recording holds the encoded units, and a replay decodes them to the same pictures. Encoder and decoder
//! use one thread, so that the same pictures give the same bits.

use std::sync::mpsc::Sender;

use barrelman_sim::World;
use barrelman_trial::campaign::{CapturedFrame, FrameSource, RenderedCamera};
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::{EncodedUnit, VideoFrame};
use bytes::Bytes;

use barrelman_video::decoder::UnitDecoder;
use barrelman_video::encoder::{EncoderSettings, H264Encoder};
use barrelman_video::mode::DecodeMode;

/// Renders, encodes and decodes the pictures of a world.
pub(super) struct EncodedCamera<'a> {
    rendered: RenderedCamera<'a>,
    encoder: H264Encoder,
    decoder: UnitDecoder,
    units: Sender<EncodedUnit>,
    index: u64,
}

impl<'a> EncodedCamera<'a> {
    /// Encodes the pictures of `rendered`. Each unit is sent to `units` before its decoded picture is
    /// delivered.
    pub(super) fn new(
        rendered: RenderedCamera<'a>,
        settings: EncoderSettings,
        units: Sender<EncodedUnit>,
    ) -> Self {
        let decoder = UnitDecoder::new(DecodeMode::Live);
        Self { rendered, encoder: H264Encoder::new(settings), decoder, units, index: 0 }
    }
}

impl FrameSource for EncodedCamera<'_> {
    fn capture(&mut self, world: &World) -> CapturedFrame {
        self.rendered.capture(world)
    }

    fn deliver(&mut self, view: &CapturedFrame) -> VideoFrame {
        let frame = &view.frame;
        let encoded = match self.encoder.encode(&frame.picture, frame.capture.at) {
            Ok(encoded) => encoded,
            Err(error) => {
                tracing::error!("{error}");
                return frame.clone();
            }
        };
        let unit = EncodedUnit {
            epoch: 0,
            index: self.index,
            capture: frame.capture,
            key: encoded.key,
            shown: true,
            rotation: Rotation::None,
            codec: UnitCodec::H264AnnexB,
            payload: Bytes::from(encoded.bytes),
        };
        self.index += 1;
        let mut decoded = None;
        if let Err(error) = self.decoder.decode(&unit, &mut |frame| decoded = Some(frame)) {
            tracing::error!("{error}");
        }
        // Without a recorder, the receiver may be gone.
        let _ = self.units.send(unit);
        decoded.unwrap_or_else(|| frame.clone())
    }
}
