//! What a session sends, and when.

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};

use super::{
    ASK_AGAIN, ASK_SPACING, ASKS_FOR_INFORMATION, ATTITUDE_INTERVAL, CLAIM_GRACE, CLAIM_TIMEOUT,
    DESCRIPTION_TIMEOUT, GimbalSession, HEARTBEAT_INTERVAL, NO_USABLE_GIMBAL, RELEASE_SPACING, RELEASES,
    SEARCH_TIMEOUT, SILENCE, SILENT, STATUS_INTERVAL, STATUS_TIMEOUT, State,
};
use crate::attitude_rate::evidence;
use crate::closing_zeros::{ClosingZeros, UNREST_SPACING};
use crate::mavlink::autopilot_reports::AUTOPILOT;
use crate::mavlink::command::{Command, Wanted};
use crate::mavlink::gimbal_reader::Holder;
use crate::mavlink::pacing::{SPACING, ZERO_REFRESH, ZERO_REPEATS};
use crate::session::{NextAction, RestEvidence};

const NO_HEARTBEAT: NextAction = NextAction::Reopen {
    reason: "no MAVLink heartbeat is heard: are address, baud rate, link.vehicle_system and the signing key right?",
};
const NO_GIMBAL: NextAction = NextAction::Reopen {
    reason: "no gimbal manager answers: does the autopilot have a gimbal (ArduPilot: MNT1_TYPE)?",
};

impl GimbalSession {
    pub(super) fn send(&mut self, command: Command, out: &mut Vec<Vec<u8>>) {
        out.push(command.encode(&mut self.writer));
    }

    fn send_zeros(&mut self, out: &mut Vec<Vec<u8>>) {
        self.send(Command::Rates(self.target(), VehicleRates::REST), out);
        if let Some(zero) = self.zooming.zero(self.target().manager.system) {
            self.send(zero, out);
        }
    }

    fn send_rates(&mut self, rates: VehicleRates, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        self.send(Command::Rates(self.target(), rates), out);
        let system = self.target().manager.system;
        if let Some(zoom) = self.zooming.due(system, rates.zoom, now) {
            self.send(zoom, out);
        }
    }

    /// Appends the packets that are due now to `out`, and returns the worker's next action.
    pub(super) fn write_due(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        if self.is_silent(now) {
            self.fell_silent = self.state != State::Yielded;
            self.state = State::Unresponsive(SILENT);
        }
        let zeros_at = self.write_left_zeros(now, out);
        let next = match self.state {
            State::Searching { since, asked, ask_at } => self.search(since, asked, ask_at, now, out),
            State::Asking { since, ask_at } => self.ask(since, ask_at, now, out),
            State::Claiming { .. } => self.claim(now, out),
            State::Up => self.poll_up(now, out),
            State::Yielded => {
                if core::mem::take(&mut self.owes_zeros) {
                    (0..=ZERO_REPEATS).for_each(|_| self.send_zeros(out));
                }
                NextAction::WaitUntil(now.plus(HEARTBEAT_INTERVAL))
            }
            State::Closing { since, zeros_sent, next_at } => {
                self.end_with_zeros(since, zeros_sent, next_at, now, out)
            }
            State::Releasing { sent, next_at } => self.release(sent, next_at, now, out),
            State::Closed => NextAction::Closed,
            State::Unresponsive(why) => why,
        };
        match (next, zeros_at) {
            (NextAction::WaitUntil(at), Some(zeros_at)) => NextAction::WaitUntil(at.min(zeros_at)),
            _ => next,
        }
    }

    /// Writes the zeros that a session before has left to be sent, if they are due. Returns when they are due
    /// next.
    fn write_left_zeros(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> Option<Timestamp> {
        let is_before_up =
            matches!(self.state, State::Searching { .. } | State::Asking { .. } | State::Claiming { .. });
        if !self.needs_answer || !is_before_up || self.has_another_commander() {
            return None;
        }
        if self.zeros_at <= now {
            self.send_zeros(out);
            self.left_zeros_sent = self.left_zeros_sent.saturating_add(1);
            let is_burst = self.left_zeros_sent <= ZERO_REPEATS;
            self.zeros_at = now.plus(if is_burst { SPACING } else { ZERO_REFRESH });
        }
        Some(self.zeros_at)
    }

    fn search(
        &mut self,
        since: Timestamp,
        mut asked: u32,
        mut ask_at: Timestamp,
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
    ) -> NextAction {
        if self.gimbal.is_some() {
            self.last_heard = Some(now);
            self.state = State::Asking { since: now, ask_at: now };
            return self.write_due(now, out);
        }
        let is_hopeless = self.reader.choice().is_hopeless()
            && self.described_at.is_some_and(|at| at.plus(DESCRIPTION_TIMEOUT) <= now);
        if is_hopeless {
            self.state = State::Unresponsive(NO_USABLE_GIMBAL);
            return NO_USABLE_GIMBAL;
        }
        if since.plus(SEARCH_TIMEOUT) <= now {
            let why = if self.candidates.is_empty() { NO_HEARTBEAT } else { NO_GIMBAL };
            self.state = State::Unresponsive(why);
            return why;
        }
        if ask_at <= now && !self.candidates.is_empty() {
            for to in self.candidates.clone() {
                self.send(Command::Request { to, message: Wanted::ManagerInformation }, out);
                // A manager that does not describe its gimbal may still say who has the control.
                if asked >= ASKS_FOR_INFORMATION {
                    self.send(Command::Request { to, message: Wanted::ManagerStatus }, out);
                }
            }
            asked += 1;
            ask_at = now.plus(ASK_SPACING);
        }
        self.state = State::Searching { since, asked, ask_at };
        let times_out_at = since.plus(SEARCH_TIMEOUT);
        NextAction::WaitUntil(if ask_at <= now { times_out_at } else { ask_at.min(times_out_at) })
    }

    fn ask(
        &mut self,
        since: Timestamp,
        mut ask_at: Timestamp,
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
    ) -> NextAction {
        if ask_at <= now {
            self.ask_for_reports(out);
            ask_at = now.plus(ASK_SPACING);
        }
        self.state = State::Asking { since, ask_at };
        let decide_at = since.plus(STATUS_TIMEOUT);
        let is_told = self.holder.is_some() || decide_at <= now;
        if is_told && (self.is_operator_asked || self.has_another_commander()) {
            self.yield_control();
        } else if is_told {
            self.begin_claiming(now, false);
        } else {
            return NextAction::WaitUntil(ask_at.min(decide_at));
        }
        self.write_due(now, out)
    }

    fn claim(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        let State::Claiming { since, mut ask_at, accepted_at, is_by_operator } = self.state else {
            return NextAction::WaitUntil(now);
        };
        let is_held = matches!(self.holder, Some(Holder::Other(_)));
        let counts_at = accepted_at.filter(|_| !is_held).map(|at| at.plus(CLAIM_GRACE));
        if counts_at.is_some_and(|at| at <= now) {
            self.begin_up();
            return self.poll_up(now, out);
        }
        if is_held && now.since(since) >= CLAIM_TIMEOUT {
            self.yield_control();
            return self.write_due(now, out);
        }
        if ask_at <= now {
            let target = self.target();
            let status = Command::Request { to: target.manager, message: Wanted::ManagerStatus };
            // A claim that was accepted is not repeated: another commander may have claimed since.
            self.send(if counts_at.is_some() { status } else { Command::Claim(target) }, out);
            ask_at = now.plus(ASK_SPACING);
        }
        self.state = State::Claiming { since, ask_at, accepted_at, is_by_operator };
        NextAction::WaitUntil(counts_at.map_or(ask_at, |at| at.min(ask_at)))
    }

    fn poll_up(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        if let Some(rates) = self.pacing.due(now) {
            if !rates.is_rest() {
                self.moved_at = Some(now);
            }
            self.send_rates(rates, now, out);
        }
        let is_missing = |last: Option<Timestamp>| last.is_none_or(|at| now.since(at) >= ASK_AGAIN);
        if self.ask_again_at <= now && (is_missing(self.last_attitude) || is_missing(self.last_status)) {
            self.ask_for_reports(out);
            self.ask_again_at = now.plus(ASK_AGAIN);
        }
        self.ask_autopilot(now, out);
        NextAction::WaitUntil(self.pacing.wake_at().min(now.plus(HEARTBEAT_INTERVAL)))
    }

    /// Asks for the position and the attitude of the vehicle, and what its camera is, where they do not come.
    fn ask_autopilot(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        let to = Address { component: AUTOPILOT, ..self.target().manager };
        let requests = self.autopilot.each_mut().map(|subscription| subscription.due(to, now));
        out.extend(requests.iter().flatten().map(|request| self.writer.write(request)));
        let requests = self.zooming.requests(self.target().manager.system, now);
        out.extend(requests.iter().flatten().map(|request| self.writer.write(request)));
    }

    fn end_with_zeros(
        &mut self,
        since: Timestamp,
        zeros_sent: u32,
        next_at: Timestamp,
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
    ) -> NextAction {
        if now < next_at {
            return NextAction::WaitUntil(next_at);
        }
        if !self.needs_zeros(since, zeros_sent, now) {
            self.state = State::Releasing { sent: 0, next_at: now };
            return self.write_due(now, out);
        }
        self.send_zeros(out);
        let zeros_sent = zeros_sent + 1;
        let is_burst = zeros_sent <= u32::from(ZERO_REPEATS);
        let next_at = now.plus(if is_burst { SPACING } else { UNREST_SPACING });
        self.state = State::Closing { since, zeros_sent, next_at };
        NextAction::WaitUntil(next_at)
    }

    fn release(
        &mut self,
        sent: u32,
        next_at: Timestamp,
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
    ) -> NextAction {
        if now < next_at {
            return NextAction::WaitUntil(next_at);
        }
        let Some(gimbal) = self.gimbal.filter(|_| sent < RELEASES) else {
            self.state = State::Closed;
            return NextAction::Closed;
        };
        self.send(Command::Release(gimbal), out);
        let next_at = now.plus(RELEASE_SPACING);
        self.state = State::Releasing { sent: sent + 1, next_at };
        NextAction::WaitUntil(next_at)
    }

    fn ask_for_reports(&mut self, out: &mut Vec<Vec<u8>>) {
        let to = self.target().manager;
        if !self.has_information {
            self.send(Command::Request { to, message: Wanted::ManagerInformation }, out);
        }
        self.send(Command::Request { to, message: Wanted::ManagerStatus }, out);
        for (message, interval) in
            [(Wanted::ManagerStatus, STATUS_INTERVAL), (Wanted::Attitude, ATTITUDE_INTERVAL)]
        {
            self.send(Command::SetInterval { to, message, interval }, out);
        }
    }

    /// Whether a gimbal manager that was found is silent. A shut-down has its own rules.
    fn is_silent(&self, now: Timestamp) -> bool {
        let counts =
            matches!(self.state, State::Asking { .. } | State::Claiming { .. } | State::Up | State::Yielded);
        counts && self.last_heard.is_some_and(|at| now.since(at) >= SILENCE)
    }

    /// Whether the shut-down has to send zeros once more.
    fn needs_zeros(&self, since: Timestamp, zeros_sent: u32, now: Timestamp) -> bool {
        let is_silent = self.last_heard.is_none_or(|heard| heard < since);
        ClosingZeros {
            sent: zeros_sent,
            least: self.least_zeros,
            sway: AngularRate::ZERO,
            evidence: self.evidence_since(since, now),
            has_seen: self.attitude.has_seen(),
            is_missing: is_silent && (self.needs_answer || self.gimbal.is_some()),
        }
        .needs_more()
    }

    pub(super) fn evidence_since(&self, since: Timestamp, now: Timestamp) -> RestEvidence {
        self.attitude.rate_since(since, now).map_or(RestEvidence::NoTelemetry, evidence)
    }
}
