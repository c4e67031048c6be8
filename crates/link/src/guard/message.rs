//! The messages between the program and its guard, one to a packet of the socket pair: a kind, then fields in
//! little-endian order. Times are those of the program's clock, which starts at a stated moment of
//! `CLOCK_MONOTONIC`.

use std::time::Duration;

use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{LinkCommand, Timestamp, VehicleRates, VesselCommand};
use barrelman_wire::{ByteProtocolName, Framing, LinkHistory, RestEvidence, VesselProtocol};

use crate::dead_mans_switch::RequestedCommand;

mod fields;
mod packets;

/// Version of the messages. Program and guard come from one build; another version is refused.
pub const VERSION: u16 = 9;
/// Largest message, bytes.
pub const MAX_MESSAGE_BYTES: usize = 4096;

/// The first message: what the guard has to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The start of the program's clock on `CLOCK_MONOTONIC`, nanoseconds.
    pub clock_start_ns: u64,
    /// What is guarded.
    pub vehicle: GuardedVehicle,
    /// What a guard before this one has left.
    pub history: LinkHistory,
    /// The address of the link with its deliberate faults.
    pub url: String,
}

/// What a guard has at the other end of its port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GuardedVehicle {
    /// A vehicle with a camera.
    Camera {
        /// The largest rates that may pass, in the vehicle's own axes.
        limits: VehicleRates,
        /// The vehicle's protocol.
        protocol: ByteProtocolName,
        /// The framing of its lines.
        framing: Framing,
    },
    /// A boat.
    Vessel {
        /// The largest throttle and rudder that may pass.
        limits: VesselCommand,
        /// The boat's protocol.
        protocol: VesselProtocol,
    },
}

/// A command that has a form in messages.
pub trait MessageCommand: LinkCommand {
    /// Appends the form of the command.
    fn put(self, out: &mut Vec<u8>);

    /// Reads a command from the beginning of `bytes`. Returns it with the bytes behind it.
    fn take(bytes: &[u8]) -> Option<(Self, &[u8])>;
}

/// A message to the guard.
#[derive(Debug, Clone, PartialEq)]
pub enum ToGuard<C = VehicleRates> {
    /// The first message.
    Settings(Settings),
    /// A command with its time to live; also the sign of life.
    Request(RequestedCommand<C>),
    /// The operator takes the control of the vehicle back.
    TakeControl,
    /// Zeros, stop, and the end.
    Close,
}

/// A message of the guard.
#[derive(Debug, Clone, PartialEq)]
pub enum FromGuard {
    /// The port was opened.
    Opened,
    /// The port could not be opened at first; the guard goes on trying.
    NotOpened {
        /// Whether the vehicle may just not be there yet.
        may_pass: bool,
        /// The reason.
        reason: String,
    },
    /// The state of the link.
    State(LinkState, Timestamp),
    /// Bytes of the vehicle.
    Received(Timestamp, Vec<u8>),
    /// The port was lost.
    Lost {
        /// Whether the camera may be turning.
        may_be_turning: bool,
        /// The reason.
        reason: String,
    },
    /// Whether another client has the control of the vehicle.
    Control {
        /// Whether it has.
        is_anothers: bool,
    },
    /// Rates were not renewed in time.
    HeldUp,
    /// The machine was suspended for this long.
    Suspended(Duration),
    /// Zeros and stop were sent.
    Stopped(RestEvidence),
    /// The guard's worker panicked.
    Panicked,
    /// The guard runs.
    Alive,
    /// The guard begins to open its port, which may take seconds.
    OpensPort,
    /// The guard ends.
    Ended {
        /// Whether zeros and stop were sent.
        is_stop_sent: bool,
    },
}

/// A message cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// The message ends too early, is too long, or has a value that no message has.
    #[error(
        "a message between program and guard cannot be read: is barrelman-guard of the same build as barrelman?"
    )]
    Malformed,
    /// The messages have another version.
    #[error("barrelman-guard is of another build than barrelman: install both together")]
    Version,
}

#[cfg(test)]
mod tests;
