//! The client of a gimbal manager: discovery, control, rates, attitude, shut-down.
//!
//! ```text
//!            information (280)               no other commander has it:    claimed: status says so, or
//!            or status (281)                 status (281), or 3 s          0.6 s after an accepted claim
//!   Searching ------------------> Asking -----------------> Claiming ---------------> Up
//!    ^  |                           | another commander        | refused, or another   | another commander
//!    |  | 10 s                      | has the control          | commander has it      | has it, or none has
//!    |  v                           v                          v                       v
//!    | Unresponsive <------------- Yielded <----------------------------------------------+
//!    | (reopen the port)             |  ^
//!    |         ^  silent for 3 s     |  | accepted, without effect for 3 s
//!    |         +-- any but Searching +--+-- take_control() --> Claiming
//!    |                               +-- status: control is ours again: Up, zeros first
//!    +--------- the vehicle restarted (after Yielded, only take_control() claims)
//!
//!   Up, Claiming -- close() --> Closing (zeros until rest) --> Releasing (1001 with -3) --> Closed
//!   any other state -- close() --> Closed
//! ```
//!
//! No rate is sent to a gimbal whose control is not ours, with one exception: where a session before may have
//! left the gimbal turning ([`LinkHistory::may_be_turning`]), zeros go to every gimbal manager that hears
//! them, from the first packet on until the manager is known to obey another commander. The control begins
//! with zeros.
//!
//! The first gimbal that is found is the gimbal: after a restart of the vehicle, and in the sessions after
//! this one, only its system is searched.
//!
//! [`GimbalSession`] is the [`Session`] of this protocol: a plain struct without I/O. It sends rates other
//! than zero only in the state `Up`. `session/due.rs` has what is sent when, `session/events.rs` what
//! received messages change.

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, ComponentId, MavlinkPeers, SystemId};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};

use super::command::{Command, Gimbal, Wanted};
use super::frame::FrameWriter;
use super::gimbal_reader::{GimbalReader, Holder};
use super::pacing::{Pacing, SPACING, ZERO_REPEATS};
use super::signing::Signing;
use super::subscription::Subscription;
use crate::attitude_rate::AttitudeRate;
use crate::closing_zeros::{ZEROS_AT_REST, ZEROS_IN_MOTION};
use crate::session::{LinkHistory, NextAction, RestEvidence, Session, WillStep};

pub use super::session_times::{
    ASK_AGAIN, ASK_SPACING, ASKS_FOR_INFORMATION, ATTITUDE_INTERVAL, CAMERA_INTERVAL, CLAIM_GRACE,
    CLAIM_TIMEOUT, DESCRIPTION_TIMEOUT, FIELD_OF_VIEW_INTERVAL, HAS_ZEROS_AFTER, HEARTBEAT_INTERVAL,
    LEAST_ATTITUDE_SPACING, MAX_CANDIDATES, POSITION_INTERVAL, RELEASE_SPACING, RELEASES, SEARCH_TIMEOUT,
    SILENCE, STATUS_INTERVAL, STATUS_TIMEOUT, VEHICLE_ATTITUDE_INTERVAL,
};

mod due;
mod events;
mod zooming;

use zooming::Zooming;

const SILENT: NextAction = NextAction::Reopen { reason: "the gimbal manager does not answer any more" };
const NO_USABLE_GIMBAL: NextAction = NextAction::Reopen { reason: "no gimbal can both pan and tilt" };

/// State of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// The components that were heard are asked for a gimbal manager at `ask_at`.
    Searching {
        since: Timestamp,
        asked: u32,
        ask_at: Timestamp,
    },
    /// The gimbal manager is asked who has the control.
    Asking {
        since: Timestamp,
        ask_at: Timestamp,
    },
    /// The control is claimed at `ask_at`. With `accepted_at`, the claim was accepted.
    Claiming {
        since: Timestamp,
        ask_at: Timestamp,
        accepted_at: Option<Timestamp>,
        is_by_operator: bool,
    },
    Up,
    /// Another commander has the control.
    Yielded,
    Closing {
        since: Timestamp,
        zeros_sent: u32,
        next_at: Timestamp,
    },
    Releasing {
        sent: u32,
        next_at: Timestamp,
    },
    Closed,
    Unresponsive(NextAction),
}

/// One session with a gimbal manager.
#[derive(Debug, Clone)]
pub struct GimbalSession {
    state: State,
    writer: FrameWriter,
    reader: GimbalReader,
    pacing: Pacing,
    zooming: Zooming,
    gimbal: Option<Gimbal>,
    /// Whether the gimbal manager has described its gimbal.
    has_information: bool,
    holder: Option<Holder>,
    /// Components that may have a gimbal manager.
    candidates: Vec<Address>,
    attitude: AttitudeRate,
    heartbeat_at: Timestamp,
    /// When missing reports are asked for again.
    ask_again_at: Timestamp,
    /// When the zeros are due that a session before has left to be sent.
    zeros_at: Timestamp,
    left_zeros_sent: u8,
    /// The autopilot's position and attitude.
    autopilot: [Subscription; 2],
    /// When a manager described a gimbal first.
    described_at: Option<Timestamp>,
    last_attitude: Option<Timestamp>,
    last_status: Option<Timestamp>,
    /// When the gimbal manager was heard last.
    last_heard: Option<Timestamp>,
    /// Whether another commander had the control when the vehicle restarted, or when a session before was
    /// lost.
    is_operator_asked: bool,
    /// Whether zeros are to be sent to a gimbal that turned when it was left without a commander.
    owes_zeros: bool,
    /// Whether a session before may have left the gimbal turning, and the control was not ours, or another
    /// commander's, since.
    needs_answer: bool,
    /// Least number of zeros of the shut-down.
    least_zeros: u32,
    /// Whether a session with a gimbal manager fell silent.
    fell_silent: bool,
    /// When rates other than zero were sent last, until the gimbal manager is heard so long after the zeros
    /// that it has them.
    moved_at: Option<Timestamp>,
    /// Whether the newest attitudes show that the gimbal turns: zeros that were sent may not have arrived.
    is_seen_turning: bool,
}

impl GimbalSession {
    /// A session on a newly opened port. With `signing`, packets are signed, and others are not read.
    pub fn open(peers: MavlinkPeers, signing: Option<Signing>, now: Timestamp) -> Self {
        Self {
            state: searching(now),
            writer: FrameWriter::new(peers.own, signing),
            reader: GimbalReader::new(peers, signing, now),
            pacing: Pacing::default(),
            zooming: Zooming::new(peers.camera),
            gimbal: None,
            has_information: false,
            holder: None,
            candidates: Vec::new(),
            attitude: AttitudeRate::new(LEAST_ATTITUDE_SPACING),
            heartbeat_at: now,
            ask_again_at: now,
            zeros_at: now,
            left_zeros_sent: 0,
            autopilot: [
                (Wanted::Position, POSITION_INTERVAL),
                (Wanted::VehicleAttitude, VEHICLE_ATTITUDE_INTERVAL),
            ]
            .map(|(message, interval)| Subscription::new(message.id(), interval)),
            described_at: None,
            last_attitude: None,
            last_status: None,
            last_heard: None,
            is_operator_asked: false,
            owes_zeros: false,
            needs_answer: false,
            least_zeros: ZEROS_AT_REST,
            fell_silent: false,
            moved_at: None,
            is_seen_turning: false,
        }
    }

    /// Whom zeros reach: the gimbal, or every gimbal manager.
    fn target(&self) -> Gimbal {
        self.gimbal.unwrap_or(everyone(self.reader.vehicle()))
    }

    fn has_another_commander(&self) -> bool {
        self.state == State::Yielded || matches!(self.holder, Some(Holder::Other(_)))
    }

    fn begin_up(&mut self) {
        self.pacing.begin_with_zeros();
        self.zooming.begin_with_zeros();
        (self.is_operator_asked, self.needs_answer) = (false, false);
        self.state = State::Up;
    }

    fn begin_claiming(&mut self, now: Timestamp, is_by_operator: bool) {
        self.state = State::Claiming { since: now, ask_at: now, accepted_at: None, is_by_operator };
    }

    /// Leaves the gimbal to the commander that has the control.
    fn yield_control(&mut self) {
        (self.needs_answer, self.owes_zeros) = (false, false);
        self.state = State::Yielded;
    }
}

fn searching(now: Timestamp) -> State {
    State::Searching { since: now, asked: 0, ask_at: now }
}

/// All gimbals of a vehicle, or of every vehicle.
fn everyone(vehicle: Option<SystemId>) -> Gimbal {
    let system = vehicle.unwrap_or(SystemId(0));
    Gimbal { manager: Address { system, component: ComponentId(0) }, ..Gimbal::ALL }
}

impl Session for GimbalSession {
    type Sent = Vec<u8>;
    type Received = [u8];
    type Command = VehicleRates;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        self.writer.set_time(now);
        let next = self.write_due(now, out);
        let NextAction::WaitUntil(at) = next else { return next };
        // After the zeros, which come first.
        if self.heartbeat_at <= now {
            self.send(Command::Heartbeat, out);
            self.heartbeat_at = now.plus(HEARTBEAT_INTERVAL);
        }
        NextAction::WaitUntil(at.min(self.heartbeat_at))
    }

    fn received(&mut self, packet: &[u8], now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        let mut heard = Vec::new();
        self.reader.read(packet, |received| heard.push(received));
        self.writer.follow(self.reader.frames());
        for received in heard {
            self.on_received(received, now, report);
        }
    }

    /// Rates are renewed at 10 Hz, and the worker requests rest in time, so that no time of renewal is sent.
    fn request(&mut self, rates: VehicleRates, _renew_by: Option<Timestamp>) {
        self.pacing.set_rates(rates);
    }

    fn take_control(&mut self, now: Timestamp) {
        self.is_operator_asked = false;
        if self.state == State::Yielded {
            self.holder = None;
            self.begin_claiming(now, true);
        }
    }

    /// Begins the shut-down: zeros at once, three times, then until telemetry shows no motion; then the
    /// control is released.
    fn close(&mut self, now: Timestamp) {
        let is_claimed = matches!(self.state, State::Claiming { accepted_at: Some(_), .. });
        self.state = match self.state {
            State::Closing { .. } | State::Releasing { .. } | State::Closed | State::Unresponsive(_) => {
                return;
            }
            _ if self.has_another_commander() => State::Closed,
            State::Up => self.closing(now),
            _ if self.needs_answer || is_claimed => self.closing(now),
            // The claim that is under way may yet be accepted.
            State::Claiming { .. } => State::Releasing { sent: 0, next_at: now },
            State::Searching { .. } | State::Asking { .. } | State::Yielded => State::Closed,
        };
    }

    fn failure(&self) -> Option<String> {
        (self.state == State::Unresponsive(NO_USABLE_GIMBAL)).then(|| self.reader.choice().to_string())
    }

    fn link_state(&self) -> LinkState {
        match self.state {
            State::Searching { .. } | State::Asking { .. } | State::Claiming { .. } => LinkState::Starting,
            State::Up | State::Yielded => LinkState::Up,
            State::Closing { .. } | State::Releasing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
            State::Unresponsive(SILENT) => LinkState::Silent,
            State::Unresponsive(_) => LinkState::Opening,
        }
    }

    fn resume(&mut self, history: LinkHistory) {
        (self.needs_answer, self.is_operator_asked) = (history.may_be_turning, history.is_anothers);
        if let Some(vehicle) = history.vehicle {
            self.reader.name(vehicle);
        }
    }

    fn vehicle(&self) -> Option<SystemId> {
        self.reader.vehicle()
    }

    fn is_anothers(&self) -> bool {
        self.is_operator_asked || self.has_another_commander()
    }

    fn may_be_turning(&self) -> bool {
        // A shut-down that is cut off may not have stopped it.
        let is_ours = matches!(self.state, State::Up | State::Closing { .. }) || self.fell_silent;
        is_ours && (self.pacing.may_be_turning() || self.moved_at.is_some() || self.is_seen_turning)
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        let since = if let State::Closing { since, .. } = self.state { since } else { Timestamp::ZERO };
        self.evidence_since(since, now)
    }

    /// Three times zeros, to the gimbal and to every gimbal manager that hears them; none to a gimbal of
    /// another commander.
    fn last_will(&self, now: Timestamp) -> Vec<WillStep<Vec<u8>>> {
        // A control that is being released has ended with zeros.
        let has_ended = matches!(self.state, State::Releasing { .. } | State::Closed);
        if has_ended || self.is_anothers() {
            return Vec::new();
        }
        let mut writer = self.writer.clone();
        writer.set_time(now);
        let mut will = Vec::new();
        for _ in 0..=ZERO_REPEATS {
            let mut targets = vec![everyone(self.reader.vehicle())];
            targets.extend(self.gimbal);
            for (index, target) in targets.iter().enumerate() {
                let pause = if index + 1 == targets.len() { SPACING } else { Duration::ZERO };
                let packet = Command::Rates(*target, VehicleRates::REST).encode(&mut writer);
                will.push(WillStep { packet, pause });
            }
            let system = self.target().manager.system;
            let zero = self.zooming.zero(system).map(|zero| zero.encode(&mut writer));
            will.extend(zero.map(|packet| WillStep { packet, pause: Duration::ZERO }));
        }
        will
    }
}

impl GimbalSession {
    fn closing(&mut self, now: Timestamp) -> State {
        if self.needs_answer || self.may_be_turning() {
            self.least_zeros = ZEROS_IN_MOTION;
        }
        State::Closing { since: now, zeros_sent: 0, next_at: now }
    }
}
