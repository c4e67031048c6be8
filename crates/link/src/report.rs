//! The reports of a link.

use std::time::Duration;

use barrelman_vocab::Telemetry;
use barrelman_wire::RestEvidence;

/// A report of a link to the run loop.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkReport {
    /// A report of the vehicle, or of the link itself.
    Telemetry(Telemetry),
    /// The port could not be opened at first, for this reason; the link goes on trying.
    NotReached(String),
    /// The port was lost; the link reopens it.
    Lost {
        /// The reason.
        reason: String,
        /// Whether the vehicle may still be turning the camera.
        may_be_turning: bool,
    },
    /// Whether another client has the control of the vehicle now, as the session takes it: reported at first
    /// and at each change.
    Control {
        /// Whether it has; the operator has not taken the control back.
        is_anothers: bool,
    },
    /// The run loop did not renew its rates in time: the link rests the camera.
    HeldUp,
    /// The machine was suspended for this long: the link rests the camera.
    Suspended(Duration),
    /// The guard has ended for this reason; another one is started.
    GuardLost(String),
    /// Zeros and the vehicle's own stop were sent, with what telemetry shows.
    Stopped(RestEvidence),
    /// The link's thread panicked, and has sent the emergency stop where the port was open.
    Panicked,
}
