//! The client's end: start-up, rates, telemetry, shut-down.
//!
//! ```text
//!              0.5 s             nsh> came back           last line sent
//!   Stopping --------> AwaitingPrompt ------------------> Starting ------------> Up
//!      ^                  |                                               |  |
//!      +------------------+-- says that it is not remote controlled ------+  |
//!                         |                                                  |
//!                         | no prompt for 3 s       telemetry silent for 3 s |
//!                         +---------------> Dead <---------------------------+
//!                                  (the port is to be opened anew)
//!
//!   any state but Closed and Dead -- close() --> Closing (zeros) -- 0.5 s after the last --> Closed
//! ```
//!
//! A plain struct: bytes and the time come in, bytes and the time to call again go out. It writes rates only
//! while `Up`, and begins `Up` with zeros, whatever the vehicle did before.

use core::time::Duration;

use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_vocab::{AngularRate, Telemetry, Timestamp, VehicleRates};

use super::command::{Command, Framing, Stream};
use super::lines::LineSplitter;
use super::pacing::{Pacing, ZERO_REPEATS, ZERO_SPACING};
use super::telemetry::parse;

/// The shell's prompt.
pub const PROMPT: &str = "nsh>";
/// From the first `stop` to the call for the prompt.
pub const PROMPT_DELAY: Duration = Duration::from_millis(500);
/// How long the prompt is waited for after it was called for.
pub const PROMPT_TIMEOUT: Duration = Duration::from_secs(3);
/// Carriage returns in the call for the prompt.
pub const PROMPT_REQUESTS: usize = 5;
/// Between the lines of the start-up that enter remote control.
pub const START_SPACING: Duration = Duration::from_millis(500);
/// Between the lines of the start-up that ask for telemetry: the shell loses lines that come too fast.
pub const REQUEST_SPACING: Duration = Duration::from_millis(50);
/// From the last zeros of the shut-down to `stop`.
pub const STOP_DELAY: Duration = Duration::from_millis(500);
/// Telemetry that was streaming and is silent for so long means that the link is dead.
pub const TELEMETRY_TIMEOUT: Duration = Duration::from_secs(3);
/// How long after the start-up the ground station may still report that it is not under remote control.
pub const CONTROL_GRACE: Duration = Duration::from_secs(2);

/// How a session talks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionSettings {
    /// What stands around a line.
    pub framing: Framing,
    /// Telemetry asked for, messages per second: 10, or 2 where the line carries 9600 baud only.
    pub telemetry_per_second: f64,
}

impl SessionSettings {
    /// The settings for a line of that many baud.
    pub fn for_baud(framing: Framing, baud: u32) -> Self {
        Self { framing, telemetry_per_second: if baud < 38_400 { 2.0 } else { 10.0 } }
    }
}

/// Where a session is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Stopping { prompt_at: Timestamp, stop_sent: bool },
    AwaitingPrompt { until: Timestamp },
    Starting { next: usize, at: Timestamp },
    Up { since: Timestamp },
    Closing { zeros_sent: u32, next_at: Timestamp },
    Closed,
    Dead,
}

impl State {
    fn stopping(now: Timestamp) -> Self {
        Self::Stopping { prompt_at: now.plus(PROMPT_DELAY), stop_sent: false }
    }
}

/// What a caller has to do after `poll`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NextAction {
    /// Poll again at that time at the latest, or when bytes or a request came in.
    WaitUntil(Timestamp),
    /// The ground station does not answer: open the port anew and begin a new session.
    Reopen,
    /// All has been stop_sent; the port can be closed.
    Closed,
}

/// One session with a ground station.
#[derive(Debug, Clone)]
pub struct Session {
    settings: SessionSettings,
    state: State,
    pacing: Pacing,
    lines: LineSplitter,
    last_telemetry: Option<Timestamp>,
    restarts: u64,
}

impl Session {
    /// A session on a port that was just opened.
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

    /// The newest rates wanted, in the vehicle's own signs. They go out once the session is up.
    pub fn set_rates(&mut self, rates: VehicleRates) {
        if !matches!(self.state, State::Closing { .. } | State::Closed | State::Dead) {
            self.pacing.set_rates(rates);
        }
    }

    /// Begins the shut-down: zeros at once, three times; half a second after the last the vehicle's own stop.
    pub fn close(&mut self, now: Timestamp) {
        if !matches!(self.state, State::Closing { .. } | State::Closed | State::Dead) {
            self.state = State::Closing { zeros_sent: 0, next_at: now };
        }
    }

    /// Takes bytes as they were read, and hands out what they report.
    pub fn receive(&mut self, bytes: &[u8], now: Timestamp, mut report: impl FnMut(Telemetry)) {
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

    /// A prompt that came before it was called for may be an old one: it does not count.
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

    /// Appends the bytes that are due now, and says when to call again.
    pub fn poll(&mut self, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
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
                self.state = State::Dead;
                NextAction::Reopen
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
            State::Dead => NextAction::Reopen,
        }
    }

    fn poll_up(&mut self, since: Timestamp, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
        self.pacing.poll(now, encoder(self.settings.framing, out));
        let silent_at = self.last_telemetry.map(|at| at.max(since).plus(TELEMETRY_TIMEOUT));
        if silent_at.is_some_and(|at| at <= now) {
            self.state = State::Dead;
            return NextAction::Reopen;
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

    /// The link's state for those who watch it.
    pub fn link_state(&self) -> LinkState {
        match self.state {
            State::Stopping { .. } | State::AwaitingPrompt { .. } | State::Starting { .. } => {
                LinkState::Starting
            }
            State::Up { .. } => LinkState::Up,
            State::Closing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
            State::Dead => LinkState::Opening,
        }
    }

    /// How often the ground station was found to have left remote control by itself.
    pub const fn restarts(&self) -> u64 {
        self.restarts
    }

    /// The bytes that stop the vehicle from any state, for whoever finds that the session itself has failed:
    /// zeros first, and half a second later the second part.
    pub fn emergency_stop(framing: Framing) -> (Vec<u8>, Vec<u8>) {
        let (mut zeros, mut stop) = (Vec::new(), Vec::new());
        for command in [Command::GimbalRest, Command::Yaw(AngularRate::ZERO)] {
            command.encode(framing, &mut zeros);
        }
        Command::Stop.encode(framing, &mut stop);
        (zeros, stop)
    }
}

fn encoder(framing: Framing, out: &mut Vec<u8>) -> impl FnMut(Command) {
    move |command| command.encode(framing, out)
}
