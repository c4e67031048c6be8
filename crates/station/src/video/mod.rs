//! Video in and out: sources, decoding, and MP4 files written.
//!
//! ```text
//! VideoUrl -> demux (files) or rtsp (network) -> EncodedUnit -> UnitDecoder -> VideoFrame
//!                                                     \-> recorder, console        Picture -> Mp4Writer
//! ```
//! An [`barrelman_vocab::EncodedUnit`] is what was received, unchanged; the same units always decode to the same frames,
//! so a recorder stores units and a replay decodes them again. [`live`] runs a source on a thread of its own,
//! in real time; [`mod@file`] reads every frame of a recording, for offline use.
//!
//! Read here: H.264 (8 bit, 4:2:0, progressive) from RTSP over TCP and from MP4 or MOV, Y4M, folders of PNG and
//! JPEG pictures. What is not read (USB cameras, other codecs and containers) is named in the error, together
//! with the command that makes it readable.

pub mod decoder;
pub mod demux;
pub mod error;
pub mod file;
pub mod live;
pub mod sink;
pub mod url;
pub mod writer;

pub mod annexb;
pub mod encoder;
mod fault;
pub(crate) mod feed;
mod mp4_mux;
pub mod pool;
mod quiet;
mod rtp_clock;
mod rtsp;
mod sps;
mod still;
pub mod supervision;

pub use error::{DecodeError, VideoError};
pub use file::FileFrames;
pub use live::{StopError, VideoHandle, spawn, spawn_world};
pub use sink::{VideoSink, VideoState};
pub use url::{VideoUrl, VideoUrlError};
