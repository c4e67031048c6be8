//! The client's end of the protocol: start-up, rates, telemetry, shut-down.
//!
//! ```text
//!             zeros, stop, 0.5 s        prompt received         last line sent, a report of the ground station
//!   Stopping -------------> AwaitingPrompt ------------> Starting ------------> Up
//!      ^                       |                                              |  | report: not under remote control
//!      |                       | no prompt for 3 s    telemetry silent for 3 s|  v
//!      |                       +------------> Unresponsive <------------------+ Yielded
//!      |                                    (reopen the port)                    |
//!      +-------------------------- take_control() -------------------------------+
//!
//!   Yielded -- close() --> Closed
//!   any other state but Closed and Unresponsive -- close() --> Closing (zeros) -- 0.5 s after the last --> Closed
//! ```
//!
//! The first bytes on a newly opened port are zeros: nobody knows which rate is in force, or whether `stop`
//! ends it. Zeros at the end are repeated until telemetry shows no motion ([`super::motion`]). A ground
//! station that gave the control to another client is left alone until the operator takes the control back,
//! also by the sessions after this one: they begin in `Yielded`.
//!
//! [`FotokiteProSession`] is the [`Session`] of this protocol: a plain struct without I/O, bytes and the time
//! in, bytes and the time of the next call out. It sends rates only in the state `Up`, which always begins
//! with zeros.

use core::time::Duration;

use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};

use super::command::Command;
use super::motion::MotionWatch;
use super::pacing::{Pacing, ZERO_SPACING};
use super::telemetry_reader::{Received, TelemetryReader};
use crate::closing_zeros::SWAY;
use crate::framing::Framing;
use crate::session::{LinkHistory, NextAction, RestEvidence, Session, WillStep};

pub use super::session_times::{
    CONTROL_GRACE, MAX_ZEROS, OPENING_ZEROS, PROMPT_DELAY, PROMPT_REQUESTS, PROMPT_TIMEOUT, REPORT_TIMEOUT,
    STOP_DELAY, TELEMETRY_TIMEOUT, UNREST_SPACING, ZEROS_AT_REST, ZEROS_IN_MOTION,
};
pub use super::start_up::{REQUEST_SPACING, START_SPACING};
pub use super::telemetry_reader::PROMPT;

mod writing;

/// Settings of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionSettings {
    /// Line framing.
    pub framing: Framing,
    /// Requested telemetry rate, messages per second: 10, or 2 on a line with 9600 baud.
    pub telemetry_per_second: f64,
}

impl SessionSettings {
    /// The settings for a line with this baud rate.
    pub fn for_baud(framing: Framing, baud: u32) -> Self {
        Self { framing, telemetry_per_second: if baud < 38_400 { 2.0 } else { 10.0 } }
    }
}

/// State of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Zeros are sent at `next_at`, until enough were sent; then `stop`, and the prompt is requested.
    Stopping {
        zeros_sent: u32,
        next_at: Timestamp,
    },
    /// Zeros are repeated at `zeros_at`: a line that lost the first ones may still have a vehicle that turns
    /// at its end.
    AwaitingPrompt {
        until: Timestamp,
        zeros_at: Timestamp,
    },
    Starting {
        next: usize,
        at: Timestamp,
    },
    Up {
        since: Timestamp,
    },
    /// Another commander has the control.
    Yielded {
        since: Timestamp,
    },
    Closing {
        since: Timestamp,
        zeros_sent: u32,
        next_at: Timestamp,
        stop_at: Timestamp,
    },
    Closed,
    Unresponsive,
}

impl State {
    fn stopping(now: Timestamp) -> Self {
        Self::Stopping { zeros_sent: 0, next_at: now }
    }
}

/// One session with a ground station.
#[derive(Debug, Clone)]
pub struct FotokiteProSession {
    settings: SessionSettings,
    state: State,
    pacing: Pacing,
    reader: TelemetryReader,
    motion: MotionWatch,
    last_telemetry: Option<Timestamp>,
    /// When anything was received last.
    last_heard: Option<Timestamp>,
    /// Whether the session must not end before the vehicle was heard.
    needs_answer: bool,
    /// Least number of zeros of the shut-down.
    least_zeros: u32,
    /// Whether the ground station reported its state in this session.
    has_reported: bool,
    /// Whether a session that was up fell silent.
    fell_silent: bool,
    /// Whether another client has the control, or had it in the session before, and the operator has not
    /// taken it back.
    is_anothers: bool,
    /// Whether the start-up was completed in this session.
    has_started: bool,
    /// Whether the newest attitudes show that the camera turns: zeros that were sent may not have arrived.
    is_seen_turning: bool,
}

impl FotokiteProSession {
    /// A session on a newly opened port.
    pub fn open(settings: SessionSettings, now: Timestamp) -> Self {
        Self {
            settings,
            state: State::stopping(now),
            pacing: Pacing::default(),
            reader: TelemetryReader::default(),
            motion: MotionWatch::default(),
            last_telemetry: None,
            last_heard: None,
            needs_answer: false,
            least_zeros: ZEROS_AT_REST,
            has_reported: false,
            fell_silent: false,
            is_anothers: false,
            has_started: false,
            is_seen_turning: false,
        }
    }

    /// Something was received. A vehicle that was silent during the shut-down may have received none of its
    /// zeros.
    fn on_heard(&mut self, now: Timestamp) {
        if let State::Closing { since, zeros_sent, next_at, .. } = &mut self.state
            && self.last_heard.is_none_or(|heard| heard < *since)
            && *zeros_sent > ZEROS_AT_REST
        {
            (*zeros_sent, *next_at) = (0, now);
        }
        self.last_heard = Some(now);
    }

    /// Handles a prompt. A prompt before the prompt requests may be an old one and is ignored.
    fn on_prompt(&mut self, now: Timestamp) {
        if let State::AwaitingPrompt { .. } = self.state {
            self.state = State::Starting { next: 0, at: now };
        }
    }

    fn on_report(&mut self, report: &Report, now: Timestamp) {
        self.motion.on_report(report, now);
        let evidence = self.motion.since(Timestamp::ZERO, now);
        self.is_seen_turning = matches!(evidence, RestEvidence::Moving { rate } if rate > SWAY);
        let Report::Ground { control, .. } = report else { return };
        self.has_reported = true;
        match (self.state, control) {
            (State::Up { since }, ControlState::Elsewhere) if now.since(since) >= CONTROL_GRACE => {
                self.is_anothers = true;
                self.state = State::Yielded { since };
            }
            // It was given back: the rates before are unknown.
            (State::Yielded { .. }, ControlState::Ours) => {
                self.is_anothers = false;
                self.pacing.forget_sent();
                self.state = if self.has_started { State::Up { since: now } } else { State::stopping(now) };
            }
            _ => {}
        }
    }
}

impl Session for FotokiteProSession {
    type Sent = Vec<u8>;
    type Received = [u8];
    type Command = VehicleRates;

    /// Lines that are due together leave in one packet.
    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        let mut lines = Vec::new();
        let next = self.write_due(now, &mut lines);
        if !lines.is_empty() {
            out.push(lines);
        }
        next
    }

    fn received(&mut self, bytes: &[u8], now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        if !bytes.is_empty() {
            self.on_heard(now);
        }
        let mut reader = core::mem::take(&mut self.reader);
        reader.read(bytes, |received| match received {
            Received::Prompt => self.on_prompt(now),
            Received::Report(content) => {
                self.last_telemetry = Some(now);
                self.on_report(&content, now);
                report(Telemetry { at: now, report: content });
            }
        });
        self.reader = reader;
    }

    /// The vehicle keeps a rate until the next one, so that no time of renewal is sent.
    fn request(&mut self, rates: VehicleRates, _renew_by: Option<Timestamp>) {
        if !matches!(self.state, State::Closing { .. } | State::Closed | State::Unresponsive) {
            self.pacing.set_rates(rates);
        }
    }

    fn take_control(&mut self, now: Timestamp) {
        self.is_anothers = false;
        if let State::Yielded { .. } = self.state {
            self.state = State::stopping(now);
        }
    }

    /// Begins the shut-down: zeros at once, three times, then until telemetry shows no motion; 0.5 s after
    /// the last, the vehicle's own stop. Nothing is sent to a vehicle of another client.
    fn close(&mut self, now: Timestamp) {
        if let State::Yielded { .. } = self.state {
            self.state = State::Closed;
        } else if !matches!(self.state, State::Closing { .. } | State::Closed | State::Unresponsive) {
            if self.needs_answer || self.may_be_turning() {
                self.least_zeros = ZEROS_IN_MOTION;
            }
            self.state = State::Closing { since: now, zeros_sent: 0, next_at: now, stop_at: now };
        }
    }

    fn link_state(&self) -> LinkState {
        match self.state {
            State::Stopping { .. } | State::AwaitingPrompt { .. } | State::Starting { .. } => {
                LinkState::Starting
            }
            State::Yielded { .. } if self.last_heard.is_none() => LinkState::Starting,
            State::Up { .. } | State::Yielded { .. } => LinkState::Up,
            State::Closing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
            State::Unresponsive if self.fell_silent => LinkState::Silent,
            State::Unresponsive => LinkState::Opening,
        }
    }

    fn resume(&mut self, history: LinkHistory) {
        (self.needs_answer, self.is_anothers) = (history.may_be_turning, history.is_anothers);
        if let (true, State::Stopping { next_at, .. }) = (history.is_anothers, self.state) {
            self.state = State::Yielded { since: next_at };
        }
    }

    fn is_anothers(&self) -> bool {
        self.is_anothers
    }

    fn may_be_turning(&self) -> bool {
        // A shut-down that is cut off may not have stopped it.
        let is_ours = matches!(self.state, State::Up { .. } | State::Closing { .. }) || self.fell_silent;
        is_ours && (self.pacing.may_be_turning() || self.is_seen_turning)
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        let since = if let State::Closing { since, .. } = self.state { since } else { Timestamp::ZERO };
        self.motion.since(since, now)
    }

    /// Three times zeros, half a second, stop; nothing to a vehicle of another client.
    fn last_will(&self, _: Timestamp) -> Vec<WillStep<Vec<u8>>> {
        if self.is_anothers {
            return Vec::new();
        }
        let mut zeros = Vec::new();
        self.send_zeros(&mut zeros);
        let mut stop = Vec::new();
        self.send(Command::Stop, &mut stop);
        let again = WillStep { packet: zeros.clone(), pause: ZERO_SPACING };
        let last = WillStep { packet: zeros, pause: ZERO_SPACING + STOP_DELAY };
        vec![again.clone(), again, last, WillStep { packet: stop, pause: Duration::ZERO }]
    }
}
