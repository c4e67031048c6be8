//! Recordings: every input and outcome of a run, and the video as received, in one MCAP file.
//!
//! [`Entry`] is what a recording is a sequence of; [`RecordingWriter`] and [`RecordingReader`] turn entries into
//! MCAP messages and back. The schema of our own messages is `proto/barrelman.proto`; the video uses the
//! schemas that Foxglove and others know. A file that was cut off (a killed process) is read up to the cut.
//!
//! Numbers are kept to the bit, but for one: protobuf leaves a zero away, so that -0.0 is read as 0.0.

pub mod entry;
mod framing;

pub mod reader;
pub mod writer;

mod convert;
pub mod table;

mod cell;
pub mod columns;
mod topics;

/// The messages as stored, generated from `proto/barrelman.proto`.
#[allow(missing_docs, unreachable_pub, clippy::all)]
mod stored {
    include!(concat!(env!("OUT_DIR"), "/barrelman.rs"));
}

pub use entry::{Entry, FrameStamp, RecordedInput, RecordedOutcome, RecordedTruth, RecordingStart};
pub use reader::{ReadError, RecordingReader};
pub use writer::{RecordingWriter, WriteError};
