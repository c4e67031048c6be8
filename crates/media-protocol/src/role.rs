//! The first message to a `barrelman-media`: what the process is for.

use serde::{Deserialize, Serialize};

use crate::format::CodedFormat;
use crate::share::ShareSettings;
use crate::source::SourceSettings;

/// The file name of the program.
pub const MEDIA_NAME: &str = "barrelman-media";

/// The build that both programs must have. A message of another build may not be readable: this one is, since
/// its form does not change.
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
    /// Serves units to readers.
    Share(ShareSettings),
}

/// What a decoder is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecoderSettings {
    /// The format of the units.
    pub format: CodedFormat,
    /// Whether a picture is delivered as soon as its unit has arrived. Where the order of display differs
    /// from that of decoding, the first pictures may then be lost. Otherwise every picture is delivered, in
    /// the order of display.
    pub is_live: bool,
}
