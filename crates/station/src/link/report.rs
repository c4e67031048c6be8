//! The reports of the link thread.

use barrelman_vocab::Telemetry;

/// A report of the link thread to the run loop.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkReport {
    /// A report of the vehicle, or of the link itself.
    Telemetry(Telemetry),
    /// The port was lost, for this reason; the link thread reopens it.
    Lost(String),
    /// The link thread panicked, and has sent the emergency stop where the port was open.
    Panicked,
}
