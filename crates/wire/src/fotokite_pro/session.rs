//! The client's end of the protocol: start-up, rates, telemetry, shut-down.
//!
//! ```text
//!              0.5 s                  prompt received         last line sent
//!   Stopping --------> AwaitingPrompt ---------------> Starting ------------> Up
//!      ^                  |                                                  |  |
//!      +------------------+-- report: not under remote control --------------+  |
//!                         |                                                     |
//!                         | no prompt for 3 s          telemetry silent for 3 s |
//!                         +---------------> Unresponsive <----------------------+
//!                                       (reopen the port)
//!
//!   any state but Closed and Unresponsive -- close() --> Closing (zeros) -- 0.5 s after the last --> Closed
//! ```
//!
//! [`FotokiteProSession`] is the [`Session`] of this protocol: a plain struct without I/O, bytes and the time in, bytes
//! and the time of the next call out. It sends rates only in the state `Up`, which always begins with zeros.

use core::time::Duration;

use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_vocab::{AngularRate, Telemetry, Timestamp, VehicleRates};

use super::command::{Command, Stream};
use super::lines::LineSplitter;
use super::pacing::{Pacing, ZERO_REPEATS, ZERO_SPACING};
use super::telemetry::parse;
use crate::framing::Framing;
use crate::session::{NextAction, Session, WillStep};

/// The shell's prompt.
pub const PROMPT: &str = "nsh>";
/// Time from the first `stop` to the prompt requests.
pub const PROMPT_DELAY: Duration = Duration::from_millis(500);
/// Longest time from the prompt requests to the prompt.
pub const PROMPT_TIMEOUT: Duration = Duration::from_secs(3);
/// Number of carriage returns that request the prompt.
pub const PROMPT_REQUESTS: usize = 5;
/// Interval between the start-up lines that enter remote control.
pub const START_SPACING: Duration = Duration::from_millis(500);
/// Interval between the start-up lines that request telemetry: the shell loses lines that arrive faster.
pub const REQUEST_SPACING: Duration = Duration::from_millis(50);
/// Time from the last zeros of the shut-down to `stop`.
pub const STOP_DELAY: Duration = Duration::from_millis(500);
/// The link counts as lost if a telemetry stream is silent for this time.
pub const TELEMETRY_TIMEOUT: Duration = Duration::from_secs(3);
/// Time after the start-up in which the ground station may still report that it is not under remote control.
pub const CONTROL_GRACE: Duration = Duration::from_secs(2);

const UNANSWERED: NextAction = NextAction::Reopen { reason: "the ground station does not answer" };

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
    Stopping { prompt_at: Timestamp, stop_sent: bool },
    AwaitingPrompt { until: Timestamp },
    Starting { next: usize, at: Timestamp },
    Up { since: Timestamp },
    Closing { zeros_sent: u32, next_at: Timestamp },
    Closed,
    Unresponsive,
}

impl State {
    fn stopping(now: Timestamp) -> Self {
        Self::Stopping { prompt_at: now.plus(PROMPT_DELAY), stop_sent: false }
    }
}

/// One session with a ground station.
#[derive(Debug, Clone)]
pub struct FotokiteProSession {
    settings: SessionSettings,
    state: State,
    pacing: Pacing,
    lines: LineSplitter,
    last_telemetry: Option<Timestamp>,
    restarts: u64,
}

impl FotokiteProSession {
    /// A session on a newly opened port.
    pub fn open(settings: SessionSettings, now: Timestamp) -> Self {
        Self {
            settings,
            state: State::stopping(now),
            pacing: Pacing::default(),
            lines: LineSplitter::default(),
            last_telemetry: None,
            restarts: 0,
        }
    }

    /// Handles a prompt. A prompt before the prompt requests may be an old one and is ignored.
    fn on_prompt(&mut self, now: Timestamp) {
        if let State::AwaitingPrompt { .. } = self.state {
            self.state = State::Starting { next: 0, at: now };
        }
    }

    fn on_report(&mut self, report: &Report, now: Timestamp) {
        let not_ours = matches!(report, Report::Ground { control: ControlState::NotOurs, .. });
        if let State::Up { since } = self.state
            && not_ours
            && now.since(since) >= CONTROL_GRACE
        {
            self.restarts += 1;
            self.state = State::stopping(now);
        }
    }

    /// Appends the lines that are due now to `out`, and returns the worker's next action.
    fn write_due(&mut self, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
        match self.state {
            State::Stopping { prompt_at, stop_sent } => {
                if !stop_sent {
                    self.send(Command::Stop, out);
                    self.state = State::Stopping { prompt_at, stop_sent: true };
                }
                if now < prompt_at {
                    return NextAction::WaitUntil(prompt_at);
                }
                for _ in 0..PROMPT_REQUESTS {
                    self.send(Command::PromptRequest, out);
                }
                let until = now.plus(PROMPT_TIMEOUT);
                self.state = State::AwaitingPrompt { until };
                NextAction::WaitUntil(until)
            }
            State::AwaitingPrompt { until } if now < until => NextAction::WaitUntil(until),
            State::AwaitingPrompt { .. } => {
                self.state = State::Unresponsive;
                UNANSWERED
            }
            State::Starting { next, at } => {
                if now < at {
                    return NextAction::WaitUntil(at);
                }
                let script = self.start_up();
                let Some(&(command, pause)) = script.get(next) else {
                    self.state = State::Up { since: now };
                    self.last_telemetry = None;
                    self.pacing.send_zeros_first(now, encoder(self.settings.framing, out));
                    return self.poll_up(now, now, out);
                };
                self.send(command, out);
                let at = now.plus(pause);
                self.state = State::Starting { next: next + 1, at };
                NextAction::WaitUntil(at)
            }
            State::Up { since } => self.poll_up(since, now, out),
            State::Closing { next_at, .. } if now < next_at => NextAction::WaitUntil(next_at),
            State::Closing { zeros_sent, .. } if zeros_sent <= u32::from(ZERO_REPEATS) => {
                self.send(Command::GimbalRest, out);
                self.send(Command::Yaw(AngularRate::ZERO), out);
                let last = zeros_sent == u32::from(ZERO_REPEATS);
                let next_at = now.plus(if last { STOP_DELAY } else { ZERO_SPACING });
                self.state = State::Closing { zeros_sent: zeros_sent + 1, next_at };
                NextAction::WaitUntil(next_at)
            }
            State::Closing { .. } => {
                self.send(Command::Stop, out);
                self.state = State::Closed;
                NextAction::Closed
            }
            State::Closed => NextAction::Closed,
            State::Unresponsive => UNANSWERED,
        }
    }

    fn poll_up(&mut self, since: Timestamp, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
        self.pacing.poll(now, encoder(self.settings.framing, out));
        let silent_at = self.last_telemetry.map(|at| at.max(since).plus(TELEMETRY_TIMEOUT));
        if silent_at.is_some_and(|at| at <= now) {
            self.state = State::Unresponsive;
            return UNANSWERED;
        }
        let wake_at = self.pacing.wake_at();
        NextAction::WaitUntil(silent_at.map_or(wake_at, |silent_at| wake_at.min(silent_at)))
    }

    /// The lines that enter remote control and start the telemetry, each with the pause after it.
    fn start_up(&self) -> [(Command, Duration); 12] {
        let (start, request) = (START_SPACING, REQUEST_SPACING);
        [
            (Command::Stop, start),
            (Command::RemoteControlStart, start),
            (Command::ChecksumsOff, start),
            (Command::TelemetryRate(self.settings.telemetry_per_second), request),
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

    fn send(&self, command: Command, out: &mut Vec<u8>) {
        command.encode(self.settings.framing, out);
    }

    /// How often the session restarted because the ground station had left remote control.
    pub const fn restarts(&self) -> u64 {
        self.restarts
    }
}

impl Session for FotokiteProSession {
    type Sent = Vec<u8>;
    type Received = [u8];

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
        for &byte in bytes {
            let mut meaning = None;
            self.lines.feed(&[byte], |line| meaning = parse(line.trim_start()));
            if self.lines.partial().trim_start() == PROMPT {
                self.lines.discard_partial();
                self.on_prompt(now);
            }
            if let Some(content) = meaning {
                self.last_telemetry = Some(now);
                self.on_report(&content, now);
                report(Telemetry { at: now, report: content });
            }
        }
    }

    /// The vehicle keeps a rate until the next one, so that no time of renewal is sent.
    fn request(&mut self, rates: VehicleRates, _renew_by: Option<Timestamp>) {
        if !matches!(self.state, State::Closing { .. } | State::Closed | State::Unresponsive) {
            self.pacing.set_rates(rates);
        }
    }

    /// Begins the shut-down: three times zeros, the first immediately; 0.5 s after the last, the vehicle's own stop.
    fn close(&mut self, now: Timestamp) {
        if !matches!(self.state, State::Closing { .. } | State::Closed | State::Unresponsive) {
            self.state = State::Closing { zeros_sent: 0, next_at: now };
        }
    }

    fn link_state(&self) -> LinkState {
        match self.state {
            State::Stopping { .. } | State::AwaitingPrompt { .. } | State::Starting { .. } => {
                LinkState::Starting
            }
            State::Up { .. } => LinkState::Up,
            State::Closing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
            State::Unresponsive => LinkState::Opening,
        }
    }

    /// Three times zeros, half a second, stop.
    fn last_will(&self) -> Vec<WillStep<Vec<u8>>> {
        let mut zeros = Vec::new();
        self.send(Command::GimbalRest, &mut zeros);
        self.send(Command::Yaw(AngularRate::ZERO), &mut zeros);
        let mut stop = Vec::new();
        self.send(Command::Stop, &mut stop);
        let again = WillStep { packet: zeros.clone(), pause: ZERO_SPACING };
        let last = WillStep { packet: zeros, pause: ZERO_SPACING + STOP_DELAY };
        vec![again.clone(), again, last, WillStep { packet: stop, pause: Duration::ZERO }]
    }
}

fn encoder(framing: Framing, out: &mut Vec<u8>) -> impl FnMut(Command) {
    move |command| command.encode(framing, out)
}
