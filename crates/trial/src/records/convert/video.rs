//! Units of video and fingerprints of video frames, to and from their stored forms.

use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, ColourEncoding};
use barrelman_vocab::{EncodedUnit, PictureSize, Timestamp, VideoNumber};
use bytes::Bytes;

use super::malformed::{Malformed, missing};
use crate::records::recorded_input::FrameFingerprint;
use crate::records::stored;

fn capture(at_ns: u64, quality: stored::CaptureQuality) -> Result<Capture, Malformed> {
    Ok(Capture { at: Timestamp::from_nanos(at_ns), quality: quality.try_into()? })
}

fn stored_capture(capture: Capture) -> (u64, i32) {
    (capture.at.as_nanos(), stored::CaptureQuality::from(capture.quality) as i32)
}

const fn number(is_second: bool) -> VideoNumber {
    if is_second { VideoNumber::Second } else { VideoNumber::First }
}

impl stored::VideoUnit {
    /// Announces a unit of this video.
    pub(in crate::records) fn announcing(video: VideoNumber, unit: &EncodedUnit) -> Self {
        let (captured_ns, capture_quality) = stored_capture(unit.capture);
        let mut message = Self {
            epoch: unit.epoch,
            index: unit.index,
            captured_ns,
            capture_quality,
            second: video == VideoNumber::Second,
            key: unit.key,
            shown: unit.shown,
            rotation_deg: match unit.rotation {
                Rotation::None => 0,
                Rotation::Clockwise90 => 90,
                Rotation::Half => 180,
                Rotation::Clockwise270 => 270,
            },
            ..Self::default()
        };
        message.codec = match unit.codec {
            UnitCodec::H264AnnexB => stored::UnitCodec::H264,
            UnitCodec::H265AnnexB => stored::UnitCodec::H265,
            UnitCodec::Vp9 => stored::UnitCodec::Vp9,
            UnitCodec::Av1 => stored::UnitCodec::Av1,
            UnitCodec::Jpeg => stored::UnitCodec::Jpeg,
            UnitCodec::Png => stored::UnitCodec::Png,
            UnitCodec::RawYuv420 { size, colour } => {
                message.width = size.width;
                message.height = size.height;
                message.matrix = stored::ColourMatrix::from(colour.matrix) as i32;
                message.range = stored::SampleRange::from(colour.range) as i32;
                stored::UnitCodec::Raw
            }
        } as i32;
        message
    }

    /// The unit that this message announced, with its payload.
    pub(in crate::records) fn with_payload(
        self,
        payload: Bytes,
    ) -> Result<(VideoNumber, EncodedUnit), Malformed> {
        let unit = self;
        let codec = match unit.codec() {
            stored::UnitCodec::H264 => UnitCodec::H264AnnexB,
            stored::UnitCodec::H265 => UnitCodec::H265AnnexB,
            stored::UnitCodec::Vp9 => UnitCodec::Vp9,
            stored::UnitCodec::Av1 => UnitCodec::Av1,
            stored::UnitCodec::Jpeg => UnitCodec::Jpeg,
            stored::UnitCodec::Png => UnitCodec::Png,
            stored::UnitCodec::Raw => UnitCodec::RawYuv420 {
                size: PictureSize::new(unit.width, unit.height),
                colour: ColourEncoding { matrix: unit.matrix().try_into()?, range: unit.range().try_into()? },
            },
            stored::UnitCodec::Unknown => return Err(missing("codec")),
        };
        let rotation = match unit.rotation_deg {
            0 => Rotation::None,
            90 => Rotation::Clockwise90,
            180 => Rotation::Half,
            270 => Rotation::Clockwise270,
            _ => return Err(missing("rotation_deg")),
        };
        let number = number(unit.second);
        let unit = EncodedUnit {
            epoch: unit.epoch,
            index: unit.index,
            capture: capture(unit.captured_ns, unit.capture_quality())?,
            key: unit.key,
            shown: unit.shown,
            rotation,
            codec,
            payload,
        };
        Ok((number, unit))
    }
}

impl From<&FrameFingerprint> for stored::FrameInput {
    fn from(stamp: &FrameFingerprint) -> Self {
        let (captured_ns, capture_quality) = stored_capture(stamp.capture);
        Self {
            step: 0,
            now_ns: 0,
            sequence: stamp.sequence,
            captured_ns,
            capture_quality,
            width: stamp.size.width,
            height: stamp.size.height,
            matrix: stored::ColourMatrix::from(stamp.colour.matrix) as i32,
            range: stored::SampleRange::from(stamp.colour.range) as i32,
            luma_hash: stamp.luma_hash,
            second: stamp.video == VideoNumber::Second,
        }
    }
}

impl TryFrom<&stored::FrameInput> for FrameFingerprint {
    type Error = Malformed;

    fn try_from(frame: &stored::FrameInput) -> Result<Self, Malformed> {
        Ok(Self {
            video: number(frame.second),
            sequence: frame.sequence,
            capture: capture(frame.captured_ns, frame.capture_quality())?,
            size: PictureSize::new(frame.width, frame.height),
            colour: ColourEncoding { matrix: frame.matrix().try_into()?, range: frame.range().try_into()? },
            luma_hash: frame.luma_hash,
        })
    }
}
