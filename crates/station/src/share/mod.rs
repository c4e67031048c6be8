//! The annotated live video for programs of others: RTSP with H.264, for FFmpeg, GStreamer, command centres.
//!
//! ```text
//! run loop --newest frame--> slot -> thread share: overlay -> H264Encoder -> barrelman-media --RTSP--> readers
//! ```
//! Nothing is copied, drawn or encoded while nobody reads. What must not be here: a request, a wait of the
//! run loop, a queue of frames.

mod address;
mod annotator;
mod failures;
mod setup;
mod slot;
mod thread;

pub use address::ShareAddress;
pub use setup::{ShareSetup, listen};
pub use slot::ShareInput;
pub use thread::ShareThread;
