//! Recordings: the inputs and outcomes of a run and the video as received, in one MCAP file.
//!
//! A recording is a sequence of [`Entry`]s; [`RecordingWriter`] and [`RecordingReader`] convert them to MCAP
//! messages and back. `proto/barrelman.proto` is the schema of this program's messages; the video uses
//! Foxglove's schemas. A truncated file (a killed process) is readable up to the end of its last complete
//! chunk.
//!
//! Numbers are stored bit-exactly, except that -0.0 is read as 0.0: protobuf omits zeros.

mod entry;
mod recorded_input;

mod indexed;
mod reader;
mod writer;

mod convert;
mod stored;
pub mod table;

mod cell;
pub mod columns;
mod topics;

mod record_lengths;

mod stored_sortie;

mod foxglove_view;
mod live_channels;

pub use entry::{
    Entry, RecordedMark, RecordedOutcome, RecordedProgress, RecordedTruth, RecordedVessel, RecordedVideo,
    RecordingStart, SimulatedTrial,
};
pub use indexed::IndexedRecording;
pub use live_channels::LiveChannels;
pub use reader::{ReadError, RecordingReader};
pub use recorded_input::{FrameFingerprint, RecordedInput};
pub use stored_sortie::read_sortie;
pub use writer::{RecordingWriter, WriteError};
