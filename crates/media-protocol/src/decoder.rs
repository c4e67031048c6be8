//! The messages of a decoder.
//!
//! A decoder answers each [`ToDecoder`] with the pictures that are ready, in the order of display, and then
//! with [`FromDecoder::Done`]. A decoder that works on a thread of its own may send pictures later; they come
//! before the `Done` of a later message.

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::ColourEncoding;
use serde::{Deserialize, Serialize};

use crate::format::CodedFormat;

/// Largest picture that a decoder delivers, in either direction. Larger pictures are scaled down.
pub const MAX_SIDE: u32 = 4096;

/// A message to a decoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToDecoder {
    /// Decode a unit, which is the payload.
    Decode {
        /// Time of display in nanoseconds. Comes back with the picture.
        pts_ns: u64,
        /// Whether decoding can start here.
        key: bool,
    },
    /// Deliver all pictures that the decoder holds back, and forget the stream: the next unit is a key frame.
    Flush,
}

/// A message of a decoder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum FromDecoder {
    /// The decoder is ready. Sent once, first.
    Ready {
        /// The element: "avdec_h265".
        element: String,
        /// Whether the element uses the machine's video hardware.
        is_hardware: bool,
    },
    /// There is no decoder of this format, or it cannot start. The process ends.
    NoDecoder {
        /// Why.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// A picture. The payload holds its Y, U and V samples, 4:2:0, without padding.
    Picture(DecodedPicture),
    /// The message with the same number, counted from 0, has been processed.
    Done {
        /// Why the unit gives no intact picture.
        damage: Option<String>,
    },
}

/// A decoded picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecodedPicture {
    /// Of the unit that the picture was decoded from.
    pub pts_ns: u64,
    /// Size of the luma plane.
    pub size: PictureSize,
    /// Colour encoding of the samples.
    pub colour: ColourEncoding,
    /// The size before a larger picture was scaled down to [`MAX_SIDE`].
    pub scaled_from: Option<PictureSize>,
}

/// The answer to [`crate::role::Role::ListDecoders`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecoderList {
    /// GStreamer's version.
    pub version: String,
    /// The decoder of each format; `None`: there is no decoder.
    pub decoders: Vec<(CodedFormat, Option<DecoderElement>)>,
}

/// A decoder element.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecoderElement {
    /// Its name.
    pub name: String,
    /// Whether it uses the machine's video hardware.
    pub is_hardware: bool,
}
