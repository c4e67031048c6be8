//! The commands that this program can send to the ground station.
//!
//! [`Command`] contains all of them. Take-off, motor stop and tether motion are not in it, so that they
//! cannot be sent. Rates are in radians per second in the vehicle's own signs, with six decimals, clamped to
//! the limits that the vehicle's known clients observe.

use core::fmt::{self, Write as _};

use barrelman_vocab::AngularRate;
use barrelman_vocab::profile::Protocol;

use crate::framing::Framing;

/// Limit of the yaw rate, rad/s.
pub const YAW_LIMIT: AngularRate = Protocol::FotokitePro.rate_limits().pan;
/// Limit of both gimbal rates, rad/s.
pub const GIMBAL_LIMIT: AngularRate = Protocol::FotokitePro.rate_limits().tilt;

/// One line to the ground station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// A carriage return, in either framing. The shell answers with its prompt.
    PromptRequest,
    /// Leaves remote control. Valid in any state.
    Stop,
    /// Enters remote control.
    RemoteControlStart,
    /// Switches the checksums of commands off.
    ChecksumsOff,
    /// Sets the rate of attitude and position telemetry, messages per second.
    TelemetryRate(f64),
    /// Switches the debug text off.
    DebugTextOff,
    /// Applies the parameter that was set last.
    CommitParameter,
    /// Starts a telemetry stream.
    Stream(Stream),
    /// Yaw rate of the flight unit.
    Yaw(AngularRate),
    /// Pitch rate of the gimbal.
    GimbalPitch(AngularRate),
    /// Pitch and roll rate of the gimbal, both zero.
    GimbalRest,
}

/// A telemetry stream that the client can request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stream {
    /// `!GSStatus`.
    GroundStatus,
    /// `!Attitude`.
    Attitude,
    /// `!Pos`.
    Position,
    /// `!FlightStatus`.
    FlightStatus,
    /// `!Gimbal`.
    Gimbal,
}

impl Command {
    /// Appends the line with its framing.
    pub fn encode(self, framing: Framing, out: &mut Vec<u8>) {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write!(text, "{self}");
        match (framing, text.is_empty()) {
            (_, true) => out.push(b'\r'),
            (Framing::CarriageReturns, false) => {
                out.push(b'\r');
                out.extend_from_slice(text.as_bytes());
                out.push(b'\r');
            }
            (Framing::LineFeed, false) => {
                out.extend_from_slice(text.as_bytes());
                out.push(b'\n');
            }
        }
    }
}

/// The line's text, without framing.
impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PromptRequest => Ok(()),
            Self::Stop => f.write_str("stop"),
            Self::RemoteControlStart => f.write_str("RemoteControl start"),
            Self::ChecksumsOff => f.write_str("Checksum 0"),
            Self::TelemetryRate(per_second) => write!(f, "Pset 117,{per_second:.1}"),
            Self::DebugTextOff => f.write_str("Pset 119,0"),
            Self::CommitParameter => f.write_str("Pcommit"),
            Self::Stream(Stream::GroundStatus) => f.write_str("Get_GroundStatus 0"),
            Self::Stream(Stream::Attitude) => f.write_str("Get_Att 0"),
            Self::Stream(Stream::Position) => f.write_str("Get_Pos 0"),
            Self::Stream(Stream::FlightStatus) => f.write_str("Get_FlightStatus 0"),
            Self::Stream(Stream::Gimbal) => f.write_str("Get_Gimbal 0"),
            Self::Yaw(rate) => write!(f, "Yaw {:.6}", encodable(*rate, YAW_LIMIT).radians_per_second()),
            Self::GimbalPitch(rate) => {
                write!(f, "GimbalPitch {:.6}", encodable(*rate, GIMBAL_LIMIT).radians_per_second())
            }
            Self::GimbalRest => f.write_str("Gimbal 0.000000,0.000000"),
        }
    }
}

/// The rate that is sent: clamped to the limit, and zero if six decimals would print it as zero. `-0.000000`
/// is never sent.
pub(super) fn encodable(rate: AngularRate, limit: AngularRate) -> AngularRate {
    let clamped = rate.clamped(limit);
    if clamped.radians_per_second().abs() <= 0.5e-6 { AngularRate::ZERO } else { clamped }
}
