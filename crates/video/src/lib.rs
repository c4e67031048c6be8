//! Video in and out: sources, decoding, and MP4 files.
//!
//! ```text
//! VideoUrl -> demux (files) or rtsp (network) -> EncodedUnit -> UnitDecoder -> VideoFrame
//!                                                     \-> recorder, console        Picture -> Mp4Writer
//! ```
//! An [`barrelman_vocab::EncodedUnit`] holds the received bytes, unchanged. The same units always decode to the same
//! frames, so a recorder stores units and a replay decodes them again. [`live`] runs a source on a thread of its own in
//! real time; [`mod@file`] reads every frame of a recording, for offline use. A source that another crate provides (a
//! simulated world) uses [`VideoHandle::start`] and a [`feed::Feed`].
//!
//! Read here: H.264 (8 bit, 4:2:0, progressive) from RTSP over TCP and from MP4 or MOV, Y4M, folders of PNG and
//! JPEG pictures. For sources that are not read here (USB cameras, other codecs and containers), the error names the
//! command that makes the source readable.
//!
//! The crate shields its users from openh264 and retina.

pub mod sink;
pub mod url;

pub mod live;

pub mod feed;

pub mod file;

pub mod demux;
mod fault;
mod rtp_clock;
mod rtsp;
pub mod supervision;

pub mod annexb;
pub mod decoder;
pub mod pool;
mod sps;
mod still;

pub mod encoder;
mod encoder_log;
mod mp4_mux;
pub mod writer;

pub mod error;

pub use error::{DecodeError, VideoError};
pub use file::FileFrames;
pub use live::{StopError, VideoHandle, spawn};
pub use sink::{VideoSink, VideoState};
pub use url::{VideoUrl, VideoUrlError};
