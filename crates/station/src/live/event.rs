//! Everything that can wake the run loop.

use barrelman_vocab::OperatorRequest;

use crate::link::LinkReport;
use barrelman_video::VideoState;

/// An event.
#[derive(Debug)]
pub enum Event {
    /// A video frame lies in the slot of the newest frame.
    Frame,
    /// The video came, went, or ended.
    Video(VideoState),
    /// The link has something to say.
    Link(LinkReport),
    /// The operator asks for something.
    Request(OperatorRequest),
    /// The program is to end, for this reason.
    Quit(QuitCause),
    /// A thread panicked.
    ThreadPanicked {
        /// Its name.
        thread: String,
    },
    /// The recording had to stop.
    RecordingFailed {
        /// Why.
        reason: String,
    },
}

/// Why the program is to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuitCause {
    /// The operator pressed `q`.
    Key,
    /// A signal, by its name.
    Signal(&'static str),
    /// Nobody reads our output any more.
    OutputClosed,
}

impl std::fmt::Display for QuitCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Key => f.write_str("q was pressed"),
            Self::Signal(name) => write!(f, "{name} was received"),
            Self::OutputClosed => f.write_str("the output was closed"),
        }
    }
}
