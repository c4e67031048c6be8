//! The client's end: start-up, rates, telemetry, shut-down.
//!
//! ```text
//!             nsh> came back           last line sent
//!   Calling ------------------> Starting ------------> Up
//!    |   ^                         |                    |
//!    |   +-- shell prompt or not remote controlled -----+   (a ground station that restarted)
//!    |                             |                    |
//!    | no prompt for 3 s           |                    | telemetry silent for 3 s
//!    +--> Dead <---------------------------------------+   (the port is to be opened anew)
//!
//!   any state but Closed and Dead -- close() --> Closing -- 0.5 s --> Closed
//! ```
//!
//! A plain struct: bytes and the time come in, bytes and the time to call again go out. It writes rates only
//! while `Up`, and begins `Up` with zeros, whatever the vehicle did before.

use core::time::Duration;

use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};

use super::command::{Command, Framing, Stream};
use super::lines::LineCutter;
use super::pacing::Pacing;
use super::telemetry::parse;

/// The shell's prompt.
pub const PROMPT: &str = "nsh>";
/// How long the prompt is waited for.
pub const PROMPT_TIMEOUT: Duration = Duration::from_secs(3);
/// From one call for the prompt to the next while it does not come.
pub const CALL_AGAIN: Duration = Duration::from_secs(1);
/// Empty lines in one call for the prompt.
pub const NUDGES: usize = 5;
/// Between the lines of the start-up that enter remote control.
pub const START_SPACING: Duration = Duration::from_millis(500);
/// Between the lines of the start-up that ask for telemetry: the shell loses lines that come too fast.
pub const REQUEST_SPACING: Duration = Duration::from_millis(50);
/// From the last zeros to `stop`.
pub const STOP_DELAY: Duration = Duration::from_millis(500);
/// Telemetry that was streaming and is silent for so long means that the link is dead.
pub const SILENCE: Duration = Duration::from_secs(3);
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
    Calling { since: Timestamp, call_at: Timestamp },
    Starting { next: usize, at: Timestamp },
    Up { since: Timestamp },
    Closing { stop_at: Timestamp },
    Closed,
    Dead,
}

/// What a caller has to do after `poll`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// Poll again at that time at the latest, or when bytes or a request came in.
    WaitUntil(Option<Timestamp>),
    /// The ground station does not answer: open the port anew and begin a new session.
    Reopen,
    /// All has been said; the port can be closed.
    Closed,
}

/// One session with a ground station.
#[derive(Debug, Clone)]
pub struct Session {
    settings: SessionSettings,
    state: State,
    pacing: Pacing,
    lines: LineCutter,
    last_telemetry: Option<Timestamp>,
    ignored_lines: u64,
    restarts: u64,
}

impl Session {
    /// A session on a port that was just opened.
    pub fn open(settings: SessionSettings, now: Timestamp) -> Self {
        Self {
            settings,
            state: State::Calling { since: now, call_at: now },
            pacing: Pacing::default(),
            lines: LineCutter::default(),
            last_telemetry: None,
            ignored_lines: 0,
            restarts: 0,
        }
    }

    /// The newest rates wanted, in the vehicle's own signs. They go out once the session is up.
    pub fn request(&mut self, rates: VehicleRates) {
        if !matches!(self.state, State::Closing { .. } | State::Closed | State::Dead) {
            self.pacing.want(rates);
        }
    }

    /// Begins the shut-down: zeros now, the vehicle's own stop half a second later.
    pub fn close(&mut self, now: Timestamp, out: &mut Vec<u8>) {
        if matches!(self.state, State::Closing { .. } | State::Closed | State::Dead) {
            return;
        }
        self.pacing.want(VehicleRates::REST);
        self.pacing.forget_told();
        self.say(Command::GimbalRest, out);
        self.pacing.poll(now, encoder(self.settings.framing, out));
        self.state = State::Closing { stop_at: now.plus(STOP_DELAY) };
    }

    /// Takes bytes as they were read, and hands out what they report.
    pub fn received(&mut self, bytes: &[u8], now: Timestamp, mut report: impl FnMut(Telemetry)) {
        let mut not_ours = false;
        let mut understood = false;
        let mut prompt = false;
        let ignored = &mut self.ignored_lines;
        self.lines.feed(bytes, |line| match parse(line) {
            Some(content) => {
                understood = true;
                if let Report::Ground { control, .. } = content {
                    not_ours = control == ControlState::NotOurs;
                }
                report(Telemetry { at: now, report: content });
            }
            None => {
                prompt |= line.starts_with(PROMPT);
                *ignored += 1;
            }
        });
        prompt |= self.lines.partial().starts_with(PROMPT);
        if understood {
            self.last_telemetry = Some(now);
        }
        self.state = match self.state {
            State::Calling { since, .. } if prompt && now >= since => State::Starting { next: 0, at: now },
            State::Up { since } if not_ours && now.since(since) >= CONTROL_GRACE => {
                self.restarts += 1;
                State::Calling { since: now, call_at: now }
            }
            other => other,
        };
    }

    /// Appends the bytes that are due now, and says when to call again.
    pub fn poll(&mut self, now: Timestamp, out: &mut Vec<u8>) -> Next {
        match self.state {
            State::Calling { since, call_at } => {
                if now.since(since) >= PROMPT_TIMEOUT {
                    self.state = State::Dead;
                    return Next::Reopen;
                }
                let mut wake = call_at;
                if now >= call_at {
                    self.say(Command::Stop, out);
                    for _ in 0..NUDGES {
                        self.say(Command::Nudge, out);
                    }
                    wake = now.plus(CALL_AGAIN);
                    self.state = State::Calling { since, call_at: wake };
                }
                Next::WaitUntil(Some(wake.min(since.plus(PROMPT_TIMEOUT))))
            }
            State::Starting { next, at } => {
                if now < at {
                    return Next::WaitUntil(Some(at));
                }
                let script = self.start_up();
                let Some(&(command, pause)) = script.get(next) else {
                    self.state = State::Up { since: now };
                    self.last_telemetry = None;
                    self.pacing.rest_first(now, encoder(self.settings.framing, out));
                    return self.poll_up(now, now, out);
                };
                self.say(command, out);
                let at = now.plus(pause);
                self.state = State::Starting { next: next + 1, at };
                Next::WaitUntil(Some(at))
            }
            State::Up { since } => self.poll_up(since, now, out),
            State::Closing { stop_at } => {
                if now < stop_at {
                    self.pacing.poll(now, encoder(self.settings.framing, out));
                    let wake = self.pacing.wake_at().map_or(stop_at, |wake| wake.min(stop_at));
                    return Next::WaitUntil(Some(wake));
                }
                self.say(Command::Stop, out);
                self.state = State::Closed;
                Next::Closed
            }
            State::Closed => Next::Closed,
            State::Dead => Next::Reopen,
        }
    }

    fn poll_up(&mut self, since: Timestamp, now: Timestamp, out: &mut Vec<u8>) -> Next {
        self.pacing.poll(now, encoder(self.settings.framing, out));
        let silent_at = self.last_telemetry.map(|at| at.max(since).plus(SILENCE));
        if silent_at.is_some_and(|at| at <= now) {
            self.state = State::Dead;
            return Next::Reopen;
        }
        Next::WaitUntil([self.pacing.wake_at(), silent_at].into_iter().flatten().min())
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

    fn say(&self, command: Command, out: &mut Vec<u8>) {
        command.encode(self.settings.framing, out);
    }

    /// The link's state for those who watch it.
    pub fn link_state(&self) -> LinkState {
        match self.state {
            State::Calling { .. } | State::Starting { .. } => LinkState::Starting,
            State::Up { .. } => LinkState::Up,
            State::Closing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
            State::Dead => LinkState::Opening,
        }
    }

    /// Lines that meant nothing to this program: echo, prompts, noise.
    pub const fn ignored_lines(&self) -> u64 {
        self.ignored_lines
    }

    /// How often the ground station was found to have left remote control by itself.
    pub const fn restarts(&self) -> u64 {
        self.restarts
    }

    /// The bytes that stop the vehicle from any state, for whoever finds that the session itself has failed:
    /// zeros first, and half a second later the second part.
    pub fn last_will(framing: Framing) -> (Vec<u8>, Vec<u8>) {
        let (mut zeros, mut stop) = (Vec::new(), Vec::new());
        let rest = barrelman_vocab::AngularRate::ZERO;
        for command in [Command::GimbalRest, Command::GimbalPitch(rest), Command::Yaw(rest)] {
            command.encode(framing, &mut zeros);
        }
        Command::Stop.encode(framing, &mut stop);
        (zeros, stop)
    }
}

fn encoder(framing: Framing, out: &mut Vec<u8>) -> impl FnMut(Command) {
    move |command| command.encode(framing, out)
}
