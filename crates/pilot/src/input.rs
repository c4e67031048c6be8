//! What a pilot can be told.

use barrelman_vocab::{OperatorRequest, Telemetry, Track, VideoFrame};

/// One input of [`crate::Pilot::step`].
#[derive(Debug, Clone, Copy)]
pub enum Input<'a> {
    /// A video frame: the pilot's own tracker looks at it.
    Frame(&'a VideoFrame),
    /// A localisation that was measured elsewhere: truth of a simulation, positions of a recorded log.
    Localisation(Track),
    /// A report of the vehicle.
    Telemetry(Telemetry),
    /// A request of the operator.
    Request(OperatorRequest),
    /// Nothing but the passing of time.
    Tick,
}
