//! The status line: mode, P, rates sent, frame rate, age of the frame, link.
//!
//! On a terminal one line that is drawn anew five times a second; elsewhere a plain line every five seconds.

use std::collections::VecDeque;
use std::io::{IsTerminal as _, Write as _, stdout};
use std::time::Duration;

use barrelman_pilot::Outcome;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Timestamp, Track, VehicleRates};

const ON_TERMINAL: Duration = Duration::from_millis(200);
const ELSEWHERE: Duration = Duration::from_secs(5);
/// The time over which the frame rate is counted.
const RATE_OVER: Duration = Duration::from_secs(2);

/// What the status line shows, collected as it happens.
#[derive(Debug)]
pub struct Status {
    on_terminal: bool,
    due: Timestamp,
    frames: VecDeque<Timestamp>,
    link: Option<LinkState>,
    dropped: u64,
    age: Option<Duration>,
    alarm: Option<String>,
    drawn: bool,
}

impl Status {
    /// A status line for this output; `link` is `None` for a dry run.
    pub fn new(link: Option<LinkState>) -> Self {
        Self {
            on_terminal: stdout().is_terminal(),
            due: Timestamp::ZERO,
            frames: VecDeque::new(),
            link,
            dropped: 0,
            age: None,
            alarm: None,
            drawn: false,
        }
    }

    /// A video frame of that age was put into the pilot; so many were replaced by newer ones so far.
    pub fn frame(&mut self, now: Timestamp, age: Option<Duration>, dropped: u64) {
        self.age = age;
        self.dropped = dropped;
        self.frames.push_back(now);
        while self.frames.front().is_some_and(|at| now.since(*at) > RATE_OVER) {
            self.frames.pop_front();
        }
    }

    /// The link's state.
    pub fn link(&mut self, state: LinkState) {
        self.link = Some(state);
    }

    /// Something that stays shown until the end.
    pub fn alarm(&mut self, text: String) {
        self.alarm = Some(text);
    }

    /// When the line wants to be drawn again.
    pub const fn due(&self) -> Timestamp {
        self.due
    }

    /// Draws the line if it is due.
    pub fn draw(&mut self, outcome: Option<&Outcome>, rates: VehicleRates, now: Timestamp) {
        if now < self.due {
            return;
        }
        self.due = now.plus(if self.on_terminal { ON_TERMINAL } else { ELSEWHERE });
        let line = self.line(outcome, rates, now);
        // Whether anybody still reads is watched elsewhere; a line that cannot be shown is no reason to fail.
        let _ = if self.on_terminal {
            self.drawn = true;
            write!(stdout().lock(), "\r\x1b[K{line}").and_then(|()| stdout().flush())
        } else {
            writeln!(stdout().lock(), "{line}")
        };
    }

    fn line(&self, outcome: Option<&Outcome>, rates: VehicleRates, now: Timestamp) -> String {
        let mode = outcome.map_or_else(|| "waiting for video".to_owned(), |outcome| outcome.mode.to_string());
        let track = match outcome.map(|outcome| outcome.track) {
            None | Some(Track::Unseeded) => "nothing selected".to_owned(),
            Some(Track::Lost { since, .. }) => format!("lost for {:.1} s", now.since(since).as_secs_f64()),
            Some(Track::Tracking(seen) | Track::Coasting(seen)) => {
                format!("confidence {:.2}", seen.confidence)
            }
        };
        let p = outcome
            .and_then(|outcome| outcome.percept)
            .map_or_else(|| "-".to_owned(), |percept| format!("{:.2}", percept.p));
        let advice = outcome.and_then(|outcome| outcome.advice).filter(|advice| {
            !advice.command.is_rest() && outcome.is_some_and(|outcome| outcome.command.is_rest())
        });
        let would = advice.map_or_else(String::new, |advice| {
            format!(
                " (would pan {:+.2} tilt {:+.2})",
                advice.command.pan.radians_per_second(),
                advice.command.tilt.radians_per_second()
            )
        });
        let age = self.age.map_or_else(|| "-".to_owned(), |age| format!("{:.0} ms", age.as_secs_f64() * 1e3));
        let per_second = self.frames.len() as f64 / RATE_OVER.as_secs_f64();
        let link = match self.link {
            None => "dry run",
            Some(LinkState::Opening) => "link opening",
            Some(LinkState::Starting) => "link starting",
            Some(LinkState::Up) => "link up",
            Some(LinkState::Closing) => "link closing",
            Some(LinkState::Closed) => "link closed",
        };
        let alarm = self.alarm.as_ref().map_or_else(String::new, |alarm| format!("  ALARM: {alarm}"));
        format!(
            "{mode} | {track} | P {p} | yaw {:+.2} pitch {:+.2} rad/s{would} | {per_second:.0} fps, age {age}, dropped {} | {link}{alarm}",
            rates.yaw.radians_per_second(),
            rates.pitch.radians_per_second(),
            self.dropped,
        )
    }
}

impl Drop for Status {
    fn drop(&mut self) {
        if self.drawn {
            let _ = writeln!(stdout().lock());
        }
    }
}
