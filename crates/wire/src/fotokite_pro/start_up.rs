//! The script of the start-up.

use core::time::Duration;

use super::command::{Command, Stream};

/// Interval between the start-up lines that enter remote control.
pub const START_SPACING: Duration = Duration::from_millis(500);
/// Interval between the start-up lines that request telemetry: the shell loses lines that arrive faster.
pub const REQUEST_SPACING: Duration = Duration::from_millis(50);

/// The lines that enter remote control and start the telemetry, each with the pause after it.
pub(super) fn start_up(telemetry_per_second: f64) -> [(Command, Duration); 12] {
    let (start, request) = (START_SPACING, REQUEST_SPACING);
    [
        (Command::Stop, start),
        (Command::RemoteControlStart, start),
        (Command::ChecksumsOff, start),
        (Command::TelemetryRate(telemetry_per_second), request),
        (Command::CommitParameter, request),
        (Command::DebugTextOff, request),
        (Command::CommitParameter, request),
        (Command::Stream(Stream::GroundStatus), request),
        (Command::Stream(Stream::Attitude), request),
        (Command::Stream(Stream::Position), request),
        (Command::Stream(Stream::FlightStatus), request),
        (Command::Stream(Stream::Gimbal), request),
    ]
}
