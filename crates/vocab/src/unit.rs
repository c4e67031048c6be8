//! Encoded units: what a video source delivered, unchanged, one picture each.
//!
//! A unit carries all that is needed to decode it again later: a recorder stores units, a replay hands them to
//! a fresh decoder and gets the same frames with the same sequence numbers.

use bytes::Bytes;

use crate::image::PictureSize;
use crate::video::{Capture, ColourEncoding};

/// How the picture of a unit must be turned to be displayed upright, clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Rotation {
    /// As stored.
    #[default]
    None,
    /// A quarter turn clockwise.
    Clockwise90,
    /// Upside down.
    Half,
    /// A quarter turn anticlockwise.
    Clockwise270,
}

impl Rotation {
    /// The size of a picture of that stored size once it is displayed.
    pub const fn displayed_size(self, stored: PictureSize) -> PictureSize {
        match self {
            Self::None | Self::Half => stored,
            Self::Clockwise90 | Self::Clockwise270 => PictureSize::new(stored.height, stored.width),
        }
    }
}

/// What the payload of a unit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum UnitCodec {
    /// One H.264 access unit: NAL units behind start codes (Annex B of ITU-T H.264), with the parameter sets in
    /// front of every key frame.
    H264AnnexB,
    /// A JPEG file.
    Jpeg,
    /// A PNG file.
    Png,
    /// The samples of the Y, U and V planes, one behind the other, 4:2:0, rows tightly packed, chroma planes half
    /// as wide and high, rounded up.
    RawYuv420 {
        /// Size of the luma plane.
        size: PictureSize,
        /// How the samples stand for colours.
        colour: ColourEncoding,
    },
}

/// One encoded picture. Cloning shares the payload.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedUnit {
    /// Counts the connections to the source, from 0: nothing of one epoch refers to a picture of another.
    pub epoch: u32,
    /// Running number of the units of this source, over all epochs, from 0.
    pub index: u64,
    /// When the picture was taken.
    pub capture: Capture,
    /// Whether decoding can begin with this unit.
    pub key: bool,
    /// Whether the picture is to be seen. An edit list may hide pictures that later ones are made from.
    pub shown: bool,
    /// How to turn the picture upright.
    pub rotation: Rotation,
    /// What the payload is.
    pub codec: UnitCodec,
    /// The bytes.
    pub payload: Bytes,
}
