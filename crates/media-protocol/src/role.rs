//! The first message to a `barrelman-media`: what the process is for.

use serde::{Deserialize, Serialize};

use crate::source::SourceSettings;

/// The file name of the program.
pub const MEDIA_NAME: &str = "barrelman-media";

/// The build that both programs must have. A message of another build may not be readable: this one is, since its form does
/// not change.
pub const BUILD: &str = env!("CARGO_PKG_VERSION");

/// The first message.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// [`BUILD`] of the program that sends this.
    pub build: String,
    /// What the process is for.
    pub role: Role,
}

/// What a process is for. It ends when the socket is closed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Role {
    /// Plays an address once: one connection. The process ends with the connection.
    Source(SourceSettings),
    /// Decodes the units of one stream.
    Decoder(DecoderSettings),
    /// Lists what can be decoded, then ends. See [`crate::decoder::DecoderList`].
    ListDecoders,
}

/// What a decoder is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecoderSettings {
    /// The format of the units.
    pub format: CodedFormat,
    /// Whether a picture is delivered as soon as its unit has arrived. Where the order of display differs from that of
    /// decoding, the first pictures may then be lost. Otherwise every picture is delivered, in the order of display.
    pub is_live: bool,
}

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
