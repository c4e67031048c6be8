//! Video input and output: sources, decoding, encoding, and MP4 files.
//!
//! ```text
//! VideoUrl -> demux (files) or rtsp (network) -> EncodedUnit -> UnitDecoder -> VideoFrame
//!                                                     \-> recorder, console        Picture -> Mp4Writer
//! ```
//! An [`barrelman_vocab::EncodedUnit`] holds the received bytes, unchanged. The same units always decode to the same
//! frames: a recorder stores units, and a replay decodes them again. [`live`] runs a source on a thread of its own in
//! real time; [`mod@file`] reads all frames of a file, for offline use. A source of another crate (a simulated world) uses
//! [`VideoHandle::start`] and a [`feed::Feed`].
//!
//! Supported: H.264 (8 bit, 4:2:0, progressive) from RTSP over TCP and from MP4 or MOV, Y4M, folders of PNG and
//! JPEG pictures. For other sources (USB cameras, other codecs and containers), the error names the command that converts
//! or serves the source.
//!
//! The crate shields its users from openh264 and retina.

mod codec;
mod media;
mod mp4;
mod source;

pub mod engine;

pub mod error;

pub use codec::{annexb, decoder, encoder, jpeg, png_file, pool};
pub use error::{DecodeError, VideoError};
pub use media::{MediaError, MediaProgram};
pub use mp4::writer;
pub use source::file::FileFrames;
pub use source::live::{StopError, VideoHandle, spawn};
pub use source::sink::{VideoSink, VideoState};
pub use source::url::{VideoUrl, VideoUrlError};
pub use source::{demux, feed, file, live, sender_clock, sink, supervision, url};
