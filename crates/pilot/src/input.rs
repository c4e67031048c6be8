//! The inputs of a pilot.

use barrelman_vocab::{OperatorRequest, Telemetry, Track, VideoFrame};

use crate::detections::Detections;

/// One input of [`crate::Pilot::step`].
#[derive(Debug, Clone, Copy)]
pub enum Input<'a> {
    /// A video frame for the pilot's own tracker.
    Frame(&'a VideoFrame),
    /// A track that was measured elsewhere: the truth of a simulation, or positions of a recorded log.
    Localisation(Track),
    /// Telemetry of the camera's vehicle.
    Telemetry(Telemetry),
    /// Telemetry of the vessel.
    VesselTelemetry(Telemetry),
    /// What a detector found in an earlier video frame. It never selects, marks or moves.
    Detections(&'a Detections),
    /// A request of the operator.
    Request(OperatorRequest),
    /// The current time only.
    Tick,
}
