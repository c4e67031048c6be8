//! Encodes pictures as H.264 access units.
//!
//! The encoder uses one thread, so that the same pictures give the same bytes. The stream states its colour
//! matrix and range, has no B-frames, and has a key frame (with parameter sets) every second of the pictures'
//! times and at each change of the size. H.264 in 4:2:0 has even sizes only: the last column or row of an odd
//! picture is left out. Not handled: pictures above 3840x2160 or below 16x16.

use std::time::Duration;

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, Picture, SampleRange};
use openh264::OpenH264API;
use openh264::encoder::{
    BitRate, ColorPrimaries, Complexity, Encoder, EncoderConfig, FrameRate, FrameType, MatrixCoefficients,
    RateControlMode, TransferCharacteristics, UsageType, VuiConfig,
};
use openh264::formats::YUVSource;

use super::encoder_log;
use crate::error::VideoError;

/// Settings of an encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderSettings {
    /// Expected pictures per second: a hint for the rate control. The times of the pictures may differ.
    pub fps: f64,
    /// Target bit rate, bits per second.
    pub bits_per_second: u32,
}

impl EncoderSettings {
    /// Settings with a bit rate that keeps an overlay sharp: 0.15 bit per pixel, 300 kbit/s to 50 Mbit/s (4.1
    /// Mbit/s at 1280x720 and 30 pictures per second).
    pub fn for_pictures(size: PictureSize, fps: f64) -> Self {
        let bits = size.area() as f64 * fps * 0.15;
        Self { fps, bits_per_second: bits.clamp(300e3, 50e6) as u32 }
    }
}

/// An encoded picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedPicture {
    /// The access unit, Annex B.
    pub bytes: Vec<u8>,
    /// Whether decoding can begin with it.
    pub key: bool,
}

/// Encodes the pictures of one video, one after the other.
pub struct H264Encoder {
    settings: EncoderSettings,
    /// Created for the first picture, and again when size or colour encoding change.
    encoder: Option<(Encoder, PictureSize, ColourEncoding)>,
    last_key: Timestamp,
}

/// Maximum interval of key frames.
const KEY_FRAME_INTERVAL: Duration = Duration::from_secs(1);

impl H264Encoder {
    /// An encoder without a stream.
    pub const fn new(settings: EncoderSettings) -> Self {
        Self { settings, encoder: None, last_key: Timestamp::ZERO }
    }

    /// Encodes the next picture, which was captured at `at`.
    ///
    /// # Errors
    /// A size that H.264 (level 5.2) does not allow.
    pub fn encode(&mut self, picture: &Picture, at: Timestamp) -> Result<EncodedPicture, VideoError> {
        self.encode_with(picture, at, false)
    }

    /// Encodes the next picture as a key frame.
    ///
    /// # Errors
    /// As [`Self::encode`].
    pub fn encode_key_frame(
        &mut self,
        picture: &Picture,
        at: Timestamp,
    ) -> Result<EncodedPicture, VideoError> {
        self.encode_with(picture, at, true)
    }

    fn encode_with(
        &mut self,
        picture: &Picture,
        at: Timestamp,
        key: bool,
    ) -> Result<EncodedPicture, VideoError> {
        let (size, colour) = (picture.size(), picture.colour());
        let failed = |reason: String| VideoError::Encode { size, reason };
        if size.width < 16 || size.height < 16 {
            return Err(failed("H.264 needs at least 16x16".to_owned()));
        }
        let is_usable = |entry: &(Encoder, PictureSize, ColourEncoding)| (entry.1, entry.2) == (size, colour);
        let kept = self.encoder.take().filter(is_usable);
        let is_first = kept.is_none();
        let entry = match kept {
            Some(entry) => entry,
            None => {
                let config = config(&self.settings, colour);
                let mut encoder = Encoder::with_api_config(OpenH264API::from_source(), config)
                    .map_err(|error| failed(error.to_string()))?;
                encoder_log::silence(&mut encoder);
                (encoder, size, colour)
            }
        };
        let (encoder, ..) = self.encoder.insert(entry);
        if !is_first && (key || at.since(self.last_key) >= KEY_FRAME_INTERVAL) {
            encoder.force_intra_frame();
        }
        let millis = openh264::Timestamp::from_millis(at.as_nanos() / 1_000_000);
        let stream =
            encoder.encode_at(&Source { picture }, millis).map_err(|error| failed(error.to_string()))?;
        let key = match stream.frame_type() {
            FrameType::IDR => true,
            FrameType::Skip | FrameType::Invalid => return Err(failed("the encoder skipped it".to_owned())),
            _ => false,
        };
        if key {
            self.last_key = at;
        }
        Ok(EncodedPicture { bytes: stream.to_vec(), key })
    }
}

fn config(settings: &EncoderSettings, colour: ColourEncoding) -> EncoderConfig {
    let vui = match colour.matrix {
        ColourMatrix::Bt709 => VuiConfig::bt709(),
        ColourMatrix::Bt601 => VuiConfig::bt601()
            .color_primaries(ColorPrimaries::Smpte170M)
            .transfer_characteristics(TransferCharacteristics::Smpte170M)
            .matrix_coefficients(MatrixCoefficients::Smpte170M),
    };
    EncoderConfig::new()
        .bitrate(BitRate::from_bps(settings.bits_per_second))
        .max_frame_rate(FrameRate::from_hz(settings.fps as f32))
        .rate_control_mode(RateControlMode::Bitrate)
        .usage_type(UsageType::CameraVideoRealTime)
        .complexity(Complexity::Low)
        .skip_frames(false)
        .num_threads(1)
        .vui(vui.full_range(colour.range == SampleRange::Full))
}

/// A picture cropped to even sides.
struct Source<'a> {
    picture: &'a Picture,
}

impl YUVSource for Source<'_> {
    fn dimensions(&self) -> (usize, usize) {
        let size = self.picture.size();
        (size.width as usize & !1, size.height as usize & !1)
    }

    fn strides(&self) -> (usize, usize, usize) {
        (self.picture.y().stride, self.picture.u().stride, self.picture.v().stride)
    }

    fn y(&self) -> &[u8] {
        self.picture.y().data
    }

    fn u(&self) -> &[u8] {
        self.picture.u().data
    }

    fn v(&self) -> &[u8] {
        self.picture.v().data
    }
}
