//! Compressed formats.

use serde::{Deserialize, Serialize};

/// A compressed format that a decoder is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum CodedFormat {
    /// H.264 in access units with start codes.
    H264,
    /// H.265 in access units with start codes.
    H265,
    /// VP9 frames.
    Vp9,
    /// AV1 temporal units (low overhead OBU stream).
    Av1,
}

impl CodedFormat {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::H264, Self::H265, Self::Vp9, Self::Av1];

    /// The name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::H264 => "H.264",
            Self::H265 => "H.265",
            Self::Vp9 => "VP9",
            Self::Av1 => "AV1",
        }
    }
}
