//! Video input and output: sources, decoding, encoding, and MP4 files.
//!
//! ```text
//! VideoUrl -> demux (files) or rtsp (network) -> EncodedUnit -> UnitDecoder -> VideoFrame
//!                                                     \-> recorder, console        Picture -> Mp4Writer
//! ```
//! An [`barrelman_vocab::EncodedUnit`] holds the received bytes, unchanged. The same units always decode to
//! the same frames: a recorder stores units, and a replay decodes them again. [`live`] runs a source on a
//! thread of its own in real time; [`frames`] reads all frames of a source, for offline use. A source of
//! another crate (a simulated world) uses [`VideoHandle::start`] and a [`feed::Feed`].
//!
//! The built-in engine reads H.264 (8 bit, 4:2:0, progressive) from RTSP over TCP and from MP4 or MOV, Y4M,
//! folders of PNG and JPEG pictures. Everything else is read by GStreamer in a program of its own
//! ([`media`]), if that is installed.
//!
//! The crate shields its users from openh264, retina and GStreamer.

mod codec;
pub mod media;
mod mp4;
mod source;

pub mod engine;

pub mod error;

pub use codec::{annexb, decoder, encoder, jpeg, mode, png_file, pool};
pub use error::{DecodeError, VideoError};
pub use mp4::writer;
pub use source::frames::VideoFrames;
pub use source::live::{StopError, VideoHandle, spawn};
pub use source::sink::{VideoSink, VideoState};
pub use source::url::{VideoUrl, VideoUrlError};
pub use source::{demux, feed, frames, live, sender_clock, sink, supervision, url};
