//! Encoded units: the unchanged output of a video source, one picture each.
//!
//! A unit contains everything that is needed to decode it later. A recorder stores units. A replay passes
//! them to a new decoder and gets the same video frames with the same sequence numbers.

use std::sync::Arc;

use bytes::Bytes;
use serde::{Deserialize, Serialize};

use crate::image::PictureSize;
use crate::video::{Capture, ColourEncoding, Picture};

/// Clockwise rotation that displays the picture of a unit upright.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub enum Rotation {
    /// No rotation.
    #[default]
    None,
    /// A quarter turn clockwise.
    Clockwise90,
    /// A half turn.
    Half,
    /// A quarter turn anticlockwise.
    Clockwise270,
}

impl Rotation {
    /// The displayed size of a picture with this stored size.
    pub const fn displayed_size(self, stored: PictureSize) -> PictureSize {
        match self {
            Self::None | Self::Half => stored,
            Self::Clockwise90 | Self::Clockwise270 => PictureSize::new(stored.height, stored.width),
        }
    }
}

/// Format of a unit's payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum UnitCodec {
    /// One H.264 access unit: NAL units with start codes (ITU-T H.264, Annex B), with the parameter sets
    /// before every key frame.
    H264AnnexB,
    /// One H.265 access unit: NAL units with start codes (ITU-T H.265, Annex B), with the parameter sets
    /// before every key frame.
    H265AnnexB,
    /// One VP9 frame, or a superframe.
    Vp9,
    /// One AV1 temporal unit as a low overhead OBU stream.
    Av1,
    /// A JPEG file.
    Jpeg,
    /// A PNG file.
    Png,
    /// The samples of the Y, U and V planes in this order, 4:2:0, without padding. The chroma planes have
    /// half the width and height, rounded up.
    RawYuv420 {
        /// Size of the luma plane.
        size: PictureSize,
        /// Colour encoding of the samples.
        colour: ColourEncoding,
    },
}

/// The payload of a [`UnitCodec::RawYuv420`] unit: the samples of the picture, shared and not copied.
pub fn raw_payload(picture: Arc<Picture>) -> Bytes {
    struct Samples(Arc<Picture>);

    impl AsRef<[u8]> for Samples {
        fn as_ref(&self) -> &[u8] {
            self.0.samples()
        }
    }

    Bytes::from_owner(Samples(picture))
}

/// One encoded picture. Cloning shares the payload.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedUnit {
    /// Number of the connection to the source, from 0. A unit never refers to a picture of another epoch.
    pub epoch: u32,
    /// Number of the unit since the start of this source, over all epochs, from 0.
    pub index: u64,
    /// Time of capture of the picture.
    pub capture: Capture,
    /// Whether decoding can start with this unit (key frame).
    pub key: bool,
    /// Whether the picture is displayed. An edit list may hide pictures that later pictures refer to.
    pub shown: bool,
    /// Rotation that displays the picture upright.
    pub rotation: Rotation,
    /// Format of the payload.
    pub codec: UnitCodec,
    /// The encoded bytes.
    pub payload: Bytes,
}
