//! The seam between a vehicle's protocol and the program: what a link does, without ports, threads and
//! clocks.
//!
//! A [`Session`] is one conversation with a vehicle, from the opened port to its end. The worker around it
//! owns the port and the clock, and decides nothing:
//!
//! ```text
//!                   request(command, renew_by), close
//!   worker ------------------------------------------------> Session
//!   worker -- received(packet, now) --> Session -- reports --> pilot
//!   worker <-- packets, when to call again --- poll(now) --- Session
//! ```
//!
//! A packet is what the vehicle's port carries at once: a few bytes of a stream, a datagram, or a request and
//! its answer. The session names both types, so that a port of another kind does not fit it.
//!
//! All rates are in the vehicle's own signs. The dead-man's switch is not here: the worker requests rest when
//! a command was not renewed in time. A protocol whose commands expire by themselves also uses `renew_by`.

use core::time::Duration;

use barrelman_vocab::mavlink::SystemId;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{AngularRate, LinkCommand, Telemetry, Timestamp};

/// What the sessions before on the same link have left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LinkHistory {
    /// Whether the camera may be turning, or the boat moving: the shut-down is complete only when the vehicle
    /// was heard.
    pub may_be_turning: bool,
    /// Whether another client had the control: it is not taken before the operator takes it back.
    pub is_anothers: bool,
    /// The MAVLink system that they spoke to: no other one is spoken to. `None`: none was found.
    pub vehicle: Option<SystemId>,
}

impl LinkHistory {
    /// What a link leaves that has ended. A vehicle that was stopped is at rest, and one of another client
    /// moves as that one wishes.
    pub const fn after(is_stop_sent: bool, is_anothers: bool, vehicle: Option<SystemId>) -> Self {
        Self { may_be_turning: !is_stop_sent && !is_anothers, is_anothers, vehicle }
    }
}

/// One conversation with a vehicle.
pub trait Session {
    /// What the session sends: a packet.
    type Sent;
    /// What the session receives: a packet, or a part of a stream of bytes.
    type Received: ?Sized;
    /// What the vehicle is told: the rates of a camera, or what is asked of a vessel.
    type Command: LinkCommand;

    /// Appends the packets that are due now to `out`, and returns the worker's next action.
    fn poll(&mut self, now: Timestamp, out: &mut Vec<Self::Sent>) -> NextAction;

    /// Processes a received packet, and passes each report of the vehicle to `report`.
    fn received(&mut self, packet: &Self::Received, now: Timestamp, report: &mut dyn FnMut(Telemetry));

    /// Sets the command, which replaces the one before. It is sent once the session is up, and is renewed or
    /// replaced until `renew_by`; `None`: rest, which needs no renewal.
    fn request(&mut self, command: Self::Command, renew_by: Option<Timestamp>);

    /// The operator takes the control back that the vehicle gave to another client. Without such a loss
    /// nothing happens: a session takes the control at its start, and never again by itself.
    fn take_control(&mut self, _now: Timestamp) {}

    /// Begins the shut-down: rest, and the vehicle's own stop where it has one.
    fn close(&mut self, now: Timestamp);

    /// The state of the link.
    fn link_state(&self) -> LinkState;

    /// Takes over from the sessions before, before the first poll.
    fn resume(&mut self, _history: LinkHistory) {}

    /// The MAVLink system that the session speaks to, where it knows one.
    fn vehicle(&self) -> Option<SystemId> {
        None
    }

    /// Whether another client has the control, or had it last, and the operator has not taken it back.
    fn is_anothers(&self) -> bool {
        false
    }

    /// Whether the vehicle may be turning the camera if nothing reaches it from now on.
    fn may_be_turning(&self) -> bool;

    /// What telemetry shows of the camera's motion.
    fn rest_evidence(&self, _now: Timestamp) -> RestEvidence {
        RestEvidence::NoTelemetry
    }

    /// Why the conversation has failed, where the reason of [`NextAction::Reopen`] does not say all.
    fn failure(&self) -> Option<String> {
        None
    }

    /// The packets that stop the vehicle from any state, each with the pause after it: for a session that has
    /// failed. None where another client has the control, or where the vehicle is not known.
    fn last_will(&self, now: Timestamp) -> Vec<WillStep<Self::Sent>>;
}

/// What telemetry shows of the camera's motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RestEvidence {
    /// No axis turns.
    AtRest,
    /// An axis turns.
    Moving {
        /// The rate of the fastest axis.
        rate: AngularRate,
    },
    /// There is no recent telemetry that tells.
    NoTelemetry,
}

/// The worker's next action after [`Session::poll`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NextAction {
    /// Poll again at this time at the latest, or earlier after a received packet or new rates.
    WaitUntil(Timestamp),
    /// The conversation has failed, for this reason: reopen the port and begin a new session.
    Reopen {
        /// The reason, in words.
        reason: &'static str,
    },
    /// The shut-down is complete: close the port.
    Closed,
}

/// A packet of a last will.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WillStep<P> {
    /// The packet.
    pub packet: P,
    /// The time until the next packet, or until the port may be closed.
    pub pause: Duration,
}
