//! The second engine: GStreamer in processes of its own, `barrelman-media` (see
//! [`barrelman_media_protocol`]).
//!
//! One process reads a source, another decodes its units, a third one serves video to readers. A process that
//! ends, stops or sends nonsense is a lost connection or a damaged unit; the caller starts the next one with
//! the next connection or the next key frame.

pub(crate) mod process;

pub(crate) mod decoder;

pub mod share;

pub use barrelman_media_protocol::decoder::{DecoderElement, DecoderList};
pub use barrelman_media_protocol::format::CodedFormat;
pub use process::{MediaError, MediaProgram, decoders};
