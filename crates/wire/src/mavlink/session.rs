//! The client of a gimbal manager: discovery, control, rates, attitude, shut-down.
//!
//! ```text
//!              information (280)           status (281), or 1 s       claimed: status says so, or
//!   Searching ------------------> Asking -----------------> Claiming ---------------> Up
//!    ^  ^  |                        | somebody else            | refused, or somebody  | somebody else,
//!    |  |  | 6 s                    | has the control          | else has the control  | or nobody
//!    |  |  v                        v                          v                       v
//!    |  | Unresponsive <---------- Yielded <----------------------------------------------+
//!    |  |  (reopen the port)        | |  ^
//!    |  |      ^  silent for 3 s    | |  | accepted, without effect for 3 s
//!    |  |      +-- any but Searching| +--+-- take_control() --> Claiming
//!    |  +------ status: control is ours again: Up, zeros first
//!    +--------- the vehicle restarted (after Yielded, only take_control() claims)
//!
//!   any state but Yielded -- close() --> Closing (zeros until rest) --> Releasing (1001 with -3) --> Closed
//!   Yielded -- close() --> Closed
//! ```
//!
//! The first packets on a newly opened port are zeros to every gimbal manager that hears them: nobody knows which rate is in
//! force, or who is there. A gimbal whose control somebody else has gets nothing until the operator takes the control back.
//!
//! [`GimbalSession`] is the [`Session`] of this protocol: a plain struct without I/O. It sends rates other than zero only in the
//! state `Up`, which begins with zeros.

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, ComponentId, MavlinkPeers, SystemId};
use barrelman_vocab::telemetry::{LinkState, Quaternion};
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};

use super::command::{Command, Gimbal, Wanted};
use super::frame::FrameWriter;
use super::gimbal_reader::{GimbalReader, Holder, Received};
use super::pacing::{Pacing, SPACING, ZERO_REFRESH, ZERO_REPEATS};
use crate::attitude_rate::{AttitudeRate, evidence};
use crate::closing_zeros::{ClosingZeros, UNREST_SPACING, ZEROS_AT_REST, ZEROS_IN_MOTION};
use crate::session::{NextAction, RestEvidence, Session, WillStep};

pub use super::session_times::{
    ASK_AGAIN, ASK_SPACING, ATTITUDE_INTERVAL, CLAIM_GRACE, CLAIM_TIMEOUT, CONTROL_GRACE, HEARTBEAT_INTERVAL,
    LEAST_ATTITUDE_SPACING, MAX_CANDIDATES, OPENING_ZEROS, RELEASE_SPACING, RELEASES, SEARCH_TIMEOUT,
    SILENCE, STATUS_INTERVAL, STATUS_TIMEOUT,
};

const SILENT: NextAction = NextAction::Reopen { reason: "the gimbal manager does not answer any more" };
const NO_HEARTBEAT: NextAction = NextAction::Reopen {
    reason: "no MAVLink heartbeat is heard: are address, baud rate and link.vehicle_system right?",
};
const NO_GIMBAL: NextAction = NextAction::Reopen {
    reason: "no gimbal manager answers: does the autopilot have a gimbal (ArduPilot: MNT1_TYPE)?",
};

/// State of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// Zeros go to everyone at `zeros_at`; the components that were heard are asked at `ask_at`.
    Searching {
        since: Timestamp,
        zeros_sent: u32,
        zeros_at: Timestamp,
        ask_at: Timestamp,
    },
    /// The gimbal manager is asked who has the control.
    Asking {
        since: Timestamp,
        ask_at: Timestamp,
        zeros_at: Timestamp,
    },
    /// The control is claimed at `ask_at`. With `accepted_at`, the claim was accepted.
    Claiming {
        since: Timestamp,
        ask_at: Timestamp,
        zeros_at: Timestamp,
        accepted_at: Option<Timestamp>,
        is_by_operator: bool,
    },
    Up {
        since: Timestamp,
    },
    /// Somebody else has the control.
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
    peers: MavlinkPeers,
    state: State,
    writer: FrameWriter,
    reader: GimbalReader,
    pacing: Pacing,
    gimbal: Option<Gimbal>,
    holder: Option<Holder>,
    /// Components that may have a gimbal manager.
    candidates: Vec<Address>,
    attitude: AttitudeRate,
    heartbeat_at: Timestamp,
    /// When missing reports are asked for again.
    ask_again_at: Timestamp,
    last_attitude: Option<Timestamp>,
    last_status: Option<Timestamp>,
    /// When the gimbal manager was heard last.
    last_heard: Option<Timestamp>,
    /// Whether somebody else had the control when the vehicle restarted.
    is_operator_asked: bool,
    /// Whether the session must not end before the vehicle was heard.
    needs_answer: bool,
    /// Least number of zeros of the shut-down.
    least_zeros: u32,
    /// Whether a session with a gimbal manager fell silent.
    fell_silent: bool,
}

impl GimbalSession {
    /// A session on a newly opened port.
    pub fn open(peers: MavlinkPeers, now: Timestamp) -> Self {
        Self {
            peers,
            state: searching(now),
            writer: FrameWriter::new(peers.own),
            reader: GimbalReader::new(peers),
            pacing: Pacing::default(),
            gimbal: None,
            holder: None,
            candidates: Vec::new(),
            attitude: AttitudeRate::new(LEAST_ATTITUDE_SPACING),
            heartbeat_at: now,
            ask_again_at: now,
            last_attitude: None,
            last_status: None,
            last_heard: None,
            is_operator_asked: false,
            needs_answer: false,
            least_zeros: ZEROS_AT_REST,
            fell_silent: false,
        }
    }

    /// Whom zeros reach: the gimbal, or whoever has one.
    fn target(&self) -> Gimbal {
        self.gimbal.unwrap_or(everyone(self.peers))
    }

    fn send(&mut self, command: Command, out: &mut Vec<Vec<u8>>) {
        out.push(command.encode(&mut self.writer));
    }

    fn send_zeros(&mut self, out: &mut Vec<Vec<u8>>) {
        self.send(Command::Rates(self.target(), VehicleRates::REST), out);
    }

    fn on_received(&mut self, received: Received, now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        match received {
            Received::Heartbeat(from, is_ground_station) => {
                let is_new = !is_ground_station && !self.candidates.contains(&from);
                if is_new && self.candidates.len() < MAX_CANDIDATES {
                    self.candidates.push(from);
                }
            }
            Received::Information(information) => {
                self.gimbal = Some(information.gimbal);
                self.on_heard(now);
            }
            Received::Holder(holder) => {
                self.last_status = Some(now);
                self.holder = Some(holder);
                self.on_holder(holder, now);
            }
            Received::ClaimAnswered { is_accepted } => self.on_claim_answered(is_accepted, now),
            Received::Attitude(attitude) => self.on_attitude(attitude, now),
            Received::Restarted => self.on_restarted(now),
            Received::Other => self.on_heard(now),
            Received::Report(content) => report(Telemetry { at: now, report: content }),
        }
    }

    /// The gimbal manager was heard. A vehicle that was silent during the shut-down may have received none of its zeros.
    fn on_heard(&mut self, now: Timestamp) {
        if let State::Closing { since, zeros_sent, next_at } = &mut self.state
            && self.last_heard.is_none_or(|heard| heard < *since)
            && *zeros_sent > ZEROS_AT_REST
        {
            (*zeros_sent, *next_at) = (0, now);
        }
        self.last_heard = Some(now);
    }

    fn on_attitude(&mut self, attitude: Quaternion, now: Timestamp) {
        self.last_attitude = Some(now);
        self.attitude.on_attitude(attitude, now);
    }

    fn on_holder(&mut self, holder: Holder, now: Timestamp) {
        match (self.state, holder) {
            (State::Asking { .. } | State::Up { .. }, Holder::Other(_)) => self.state = State::Yielded,
            (State::Claiming { is_by_operator: false, .. }, Holder::Other(_)) => self.state = State::Yielded,
            (State::Up { since }, Holder::Nobody) if now.since(since) >= CONTROL_GRACE => {
                self.state = State::Yielded;
            }
            // The rates before are unknown.
            (State::Claiming { .. } | State::Yielded, Holder::Us) => self.begin_up(now),
            _ => {}
        }
    }

    fn on_claim_answered(&mut self, is_accepted: bool, now: Timestamp) {
        match &mut self.state {
            State::Claiming { accepted_at, .. } if is_accepted => {
                accepted_at.get_or_insert(now);
            }
            State::Claiming { .. } => self.state = State::Yielded,
            State::Releasing { sent, next_at } => (*sent, *next_at) = (RELEASES, now),
            _ => {}
        }
    }

    fn on_restarted(&mut self, now: Timestamp) {
        if matches!(self.state, State::Closing { .. } | State::Releasing { .. } | State::Closed) {
            return;
        }
        self.is_operator_asked |= self.state == State::Yielded;
        (self.gimbal, self.holder, self.state) = (None, None, searching(now));
    }

    fn begin_up(&mut self, now: Timestamp) {
        self.pacing.begin_with_zeros();
        self.is_operator_asked = false;
        self.state = State::Up { since: now };
    }

    fn begin_claiming(&mut self, now: Timestamp, is_by_operator: bool) {
        self.state =
            State::Claiming { since: now, ask_at: now, zeros_at: now, accepted_at: None, is_by_operator };
    }

    /// Appends the packets that are due now to `out`, and returns the worker's next action.
    fn write_due(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        match self.state {
            State::Searching { .. } => self.search(now, out),
            _ if self.is_silent(now) => {
                self.fell_silent = self.state != State::Yielded;
                self.state = State::Unresponsive(SILENT);
                SILENT
            }
            State::Asking { since, ask_at, zeros_at } => {
                let zeros_at = self.zeros_due(zeros_at, now, out);
                let ask_at = if ask_at <= now {
                    self.ask_for_reports(out);
                    now.plus(ASK_SPACING)
                } else {
                    ask_at
                };
                self.state = State::Asking { since, ask_at, zeros_at };
                let decide_at = since.plus(STATUS_TIMEOUT);
                let is_told = self.holder.is_some() || decide_at <= now;
                let is_held = matches!(self.holder, Some(Holder::Other(_)));
                if is_told && (self.is_operator_asked || is_held) {
                    self.state = State::Yielded;
                } else if is_told {
                    self.begin_claiming(now, false);
                } else {
                    return NextAction::WaitUntil(zeros_at.min(ask_at).min(decide_at));
                }
                self.write_due(now, out)
            }
            State::Claiming { since, ask_at, zeros_at, accepted_at, is_by_operator } => {
                let counts_at = accepted_at
                    .filter(|_| !matches!(self.holder, Some(Holder::Other(_))))
                    .map_or(Timestamp::from_nanos(u64::MAX), |at| at.plus(CLAIM_GRACE));
                if counts_at <= now {
                    self.begin_up(now);
                    return self.poll_up(now, out);
                }
                let is_held = matches!(self.holder, Some(Holder::Other(_)));
                if is_held && now.since(since) >= CLAIM_TIMEOUT {
                    self.state = State::Yielded;
                    return self.write_due(now, out);
                }
                let zeros_at = self.zeros_due(zeros_at, now, out);
                let ask_at = if ask_at <= now {
                    self.send(Command::Claim(self.target()), out);
                    now.plus(ASK_SPACING)
                } else {
                    ask_at
                };
                self.state = State::Claiming { since, ask_at, zeros_at, accepted_at, is_by_operator };
                NextAction::WaitUntil(zeros_at.min(ask_at).min(counts_at))
            }
            State::Up { .. } => self.poll_up(now, out),
            State::Yielded => NextAction::WaitUntil(now.plus(HEARTBEAT_INTERVAL)),
            State::Closing { next_at, .. } | State::Releasing { next_at, .. } if now < next_at => {
                NextAction::WaitUntil(next_at)
            }
            State::Closing { since, zeros_sent, .. } if self.needs_zeros(since, zeros_sent, now) => {
                self.send_zeros(out);
                let zeros_sent = zeros_sent + 1;
                let is_burst = zeros_sent <= u32::from(ZERO_REPEATS);
                let next_at = now.plus(if is_burst { SPACING } else { UNREST_SPACING });
                self.state = State::Closing { since, zeros_sent, next_at };
                NextAction::WaitUntil(next_at)
            }
            State::Closing { .. } => {
                self.state = State::Releasing { sent: 0, next_at: now };
                self.write_due(now, out)
            }
            State::Releasing { sent, .. } => match self.gimbal {
                Some(gimbal) if sent < RELEASES => {
                    self.send(Command::Release(gimbal), out);
                    let next_at = now.plus(RELEASE_SPACING);
                    self.state = State::Releasing { sent: sent + 1, next_at };
                    NextAction::WaitUntil(next_at)
                }
                _ => {
                    self.state = State::Closed;
                    NextAction::Closed
                }
            },
            State::Closed => NextAction::Closed,
            State::Unresponsive(why) => why,
        }
    }

    fn search(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        let State::Searching { since, mut zeros_sent, mut zeros_at, mut ask_at } = self.state else {
            return NextAction::WaitUntil(now);
        };
        if zeros_at <= now {
            self.send_zeros(out);
            zeros_sent += 1;
            zeros_at = now.plus(if zeros_sent < OPENING_ZEROS { SPACING } else { ZERO_REFRESH });
        }
        if zeros_sent >= OPENING_ZEROS {
            if self.gimbal.is_some() {
                self.last_heard = Some(now);
                self.state = State::Asking { since: now, ask_at: now, zeros_at };
                return self.write_due(now, out);
            }
            if since.plus(SEARCH_TIMEOUT) <= now {
                let why = if self.candidates.is_empty() { NO_HEARTBEAT } else { NO_GIMBAL };
                self.state = State::Unresponsive(why);
                return why;
            }
            if ask_at <= now && !self.candidates.is_empty() {
                for to in self.candidates.clone() {
                    self.send(Command::Request { to, message: Wanted::ManagerInformation }, out);
                }
                ask_at = now.plus(ASK_SPACING);
            }
        }
        self.state = State::Searching { since, zeros_sent, zeros_at, ask_at };
        NextAction::WaitUntil(if ask_at <= now { zeros_at } else { zeros_at.min(ask_at) })
    }

    fn poll_up(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        if let Some(rates) = self.pacing.due(now) {
            self.send(Command::Rates(self.target(), rates), out);
        }
        let is_missing = |last: Option<Timestamp>| last.is_none_or(|at| now.since(at) >= ASK_AGAIN);
        if self.ask_again_at <= now && (is_missing(self.last_attitude) || is_missing(self.last_status)) {
            self.ask_for_reports(out);
            self.ask_again_at = now.plus(ASK_AGAIN);
        }
        NextAction::WaitUntil(self.pacing.wake_at().min(now.plus(HEARTBEAT_INTERVAL)))
    }

    /// Sends zeros if they are due, and returns when they are due next.
    fn zeros_due(&mut self, zeros_at: Timestamp, now: Timestamp, out: &mut Vec<Vec<u8>>) -> Timestamp {
        if now < zeros_at {
            return zeros_at;
        }
        self.send_zeros(out);
        now.plus(ZERO_REFRESH)
    }

    fn ask_for_reports(&mut self, out: &mut Vec<Vec<u8>>) {
        let to = self.target().manager;
        self.send(Command::Request { to, message: Wanted::ManagerStatus }, out);
        for (message, interval) in
            [(Wanted::ManagerStatus, STATUS_INTERVAL), (Wanted::Attitude, ATTITUDE_INTERVAL)]
        {
            self.send(Command::SetInterval { to, message, interval }, out);
        }
    }

    /// Whether a gimbal manager that was found is silent. A shut-down has its own rules.
    fn is_silent(&self, now: Timestamp) -> bool {
        let counts = matches!(
            self.state,
            State::Asking { .. } | State::Claiming { .. } | State::Up { .. } | State::Yielded
        );
        counts && self.last_heard.is_some_and(|at| now.since(at) >= SILENCE)
    }

    /// Whether the shut-down has to send zeros once more.
    fn needs_zeros(&self, since: Timestamp, zeros_sent: u32, now: Timestamp) -> bool {
        let is_silent = self.last_heard.is_none_or(|heard| heard < since);
        ClosingZeros {
            sent: zeros_sent,
            least: self.least_zeros,
            evidence: self.evidence_since(since, now),
            has_seen: self.attitude.has_seen(),
            is_missing: is_silent && (self.needs_answer || self.gimbal.is_some()),
        }
        .needs_more()
    }

    fn evidence_since(&self, since: Timestamp, now: Timestamp) -> RestEvidence {
        self.attitude.rate_since(since, now).map_or(RestEvidence::NoTelemetry, evidence)
    }
}

fn searching(now: Timestamp) -> State {
    State::Searching { since: now, zeros_sent: 0, zeros_at: now, ask_at: now }
}

/// All gimbals of the configured vehicle, or of every vehicle.
fn everyone(peers: MavlinkPeers) -> Gimbal {
    let system = peers.vehicle.unwrap_or(SystemId(0));
    Gimbal { manager: Address { system, component: ComponentId(0) }, ..Gimbal::ALL }
}

impl Session for GimbalSession {
    type Sent = Vec<u8>;
    type Received = [u8];

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
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
        let mut reader = self.reader.clone();
        reader.read(packet, |received| self.on_received(received, now, report));
        self.reader = reader;
    }

    /// Rates are renewed at 10 Hz, and the worker requests rest in time, so that no time of renewal is sent.
    fn request(&mut self, rates: VehicleRates, _renew_by: Option<Timestamp>) {
        self.pacing.set_rates(rates);
    }

    fn take_control(&mut self, now: Timestamp) {
        if self.state == State::Yielded {
            self.holder = None;
            self.begin_claiming(now, true);
        }
    }

    /// Begins the shut-down: zeros at once, three times, then until telemetry shows no motion; then the control is released.
    fn close(&mut self, now: Timestamp) {
        match self.state {
            State::Closing { .. } | State::Releasing { .. } | State::Closed | State::Unresponsive(_) => {}
            State::Yielded => self.state = State::Closed,
            _ => {
                if self.needs_answer || self.may_be_turning() {
                    self.least_zeros = ZEROS_IN_MOTION;
                }
                self.state = State::Closing { since: now, zeros_sent: 0, next_at: now };
            }
        }
    }

    fn link_state(&self) -> LinkState {
        match self.state {
            State::Searching { .. } | State::Asking { .. } | State::Claiming { .. } => LinkState::Starting,
            State::Up { .. } | State::Yielded => LinkState::Up,
            State::Closing { .. } | State::Releasing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
            State::Unresponsive(SILENT) => LinkState::Silent,
            State::Unresponsive(_) => LinkState::Opening,
        }
    }

    fn must_be_answered(&mut self) {
        self.needs_answer = true;
    }

    fn may_be_turning(&self) -> bool {
        let is_ours = matches!(self.state, State::Up { .. }) || self.fell_silent;
        is_ours && self.pacing.may_be_turning()
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        let since = if let State::Closing { since, .. } = self.state { since } else { Timestamp::ZERO };
        self.evidence_since(since, now)
    }

    /// Three times zeros, to the gimbal and to every gimbal manager that hears them; none to a gimbal that somebody else has.
    fn last_will(&self) -> Vec<WillStep<Vec<u8>>> {
        if self.state == State::Yielded {
            return Vec::new();
        }
        let mut writer = self.writer.clone();
        let mut will = Vec::new();
        for _ in 0..=ZERO_REPEATS {
            let mut targets = vec![everyone(self.peers)];
            targets.extend(self.gimbal);
            for (index, target) in targets.iter().enumerate() {
                let pause = if index + 1 == targets.len() { SPACING } else { Duration::ZERO };
                let packet = Command::Rates(*target, VehicleRates::REST).encode(&mut writer);
                will.push(WillStep { packet, pause });
            }
        }
        will
    }
}
