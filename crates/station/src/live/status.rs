//! The status line: mode, P, rates sent, frame rate, age of the frame, link.
//!
//! On a terminal one line that is drawn anew five times a second; elsewhere a plain line every five seconds. It is
//! written on a thread of its own: an output that nobody reads, or a terminal that was held with Ctrl-S, must not
//! hold the pilot. A line that could not be written in time is replaced by the next.

use std::collections::VecDeque;
use std::io::{IsTerminal as _, Write as _, stdout};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use barrelman_pilot::Outcome;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Timestamp, Track, VehicleRates};

use super::event::Event;
use super::threads::{self, FaultInjector};
use barrelman_host::clock::Clock;

const TERMINAL_INTERVAL: Duration = Duration::from_millis(200);
const PLAIN_INTERVAL: Duration = Duration::from_secs(5);
/// The time over which the frame rate is counted.
const FRAME_RATE_WINDOW: Duration = Duration::from_secs(2);
/// How long the end of the program waits for the last line.
const LAST_LINE_TIMEOUT: Duration = Duration::from_millis(200);

/// What the status line shows, collected as it happens.
#[derive(Debug)]
pub struct Status {
    lines: Option<SyncSender<String>>,
    writer: Option<JoinHandle<()>>,
    on_terminal: bool,
    first_frame: Option<Timestamp>,
    due: Timestamp,
    frames: VecDeque<Timestamp>,
    link: Option<LinkState>,
    dropped: u64,
    age: Option<Duration>,
    alarm: Option<String>,
}

impl Status {
    /// A status line for this output; `link` is `None` for a dry run.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub fn start(
        link: Option<LinkState>,
        clock: Clock,
        fault_injector: FaultInjector,
        events: SyncSender<Event>,
    ) -> std::io::Result<Self> {
        let on_terminal = stdout().is_terminal();
        let (lines, queue) = sync_channel(1);
        let apply_faults = move || fault_injector.apply_faults("status", clock.now());
        let writer =
            threads::spawn("status", events, move || write_lines(&queue, on_terminal, apply_faults))?;
        Ok(Self {
            lines: Some(lines),
            writer: Some(writer),
            on_terminal,
            first_frame: None,
            due: Timestamp::ZERO,
            frames: VecDeque::new(),
            link,
            dropped: 0,
            age: None,
            alarm: None,
        })
    }

    /// A video frame of that age was put into the pilot; so many were replaced by newer ones so far.
    pub fn frame(&mut self, now: Timestamp, age: Option<Duration>, dropped: u64) {
        self.age = age;
        self.dropped = dropped;
        self.first_frame.get_or_insert(now);
        self.frames.push_back(now);
        while self.frames.front().is_some_and(|at| now.since(*at) > FRAME_RATE_WINDOW) {
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

    /// Hands the line to its thread if it is due. Never waits.
    pub fn show(&mut self, outcome: Option<&Outcome>, rates: VehicleRates, now: Timestamp) {
        if now < self.due {
            return;
        }
        self.due = now.plus(if self.on_terminal { TERMINAL_INTERVAL } else { PLAIN_INTERVAL });
        let line = self.line(outcome, rates, now);
        if let Some(lines) = &self.lines {
            // Where the last line is not written yet, this one is left out.
            let _ = lines.try_send(line);
        }
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
        let counted_s =
            self.first_frame.map_or(0.0, |first| now.since(first).min(FRAME_RATE_WINDOW).as_secs_f64());
        let per_second = if counted_s > 0.2 { self.frames.len() as f64 / counted_s } else { 0.0 };
        let link = self.link.map_or("dry run", in_words);
        let sent = if self.link == Some(LinkState::Up) { "" } else { " (not sent)" };
        let alarm = self.alarm.as_ref().map_or_else(String::new, |alarm| format!("  ALARM: {alarm}"));
        format!(
            "{mode} | {track} | P {p} | yaw {:+.2} pitch {:+.2} rad/s{sent}{would} | {per_second:.0} fps, age {age}, dropped {} | {link}{alarm}",
            rates.yaw.radians_per_second(),
            rates.pitch.radians_per_second(),
            self.dropped,
        )
    }
}

impl Drop for Status {
    fn drop(&mut self) {
        self.lines = None;
        // A writer that nobody lets write is left behind: the program ends without it.
        let deadline = Instant::now() + LAST_LINE_TIMEOUT;
        while self.writer.as_ref().is_some_and(|writer| !writer.is_finished()) && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn write_lines(queue: &Receiver<String>, on_terminal: bool, apply_faults: impl Fn()) {
    let mut drawn = false;
    while let Ok(line) = queue.recv() {
        apply_faults();
        // Whether anybody still reads is watched elsewhere; a line that cannot be shown is no reason to fail.
        let _ = if on_terminal {
            drawn = true;
            write!(stdout().lock(), "\r\x1b[K{line}").and_then(|()| stdout().flush())
        } else {
            writeln!(stdout().lock(), "{line}")
        };
    }
    if drawn {
        let _ = writeln!(stdout().lock());
    }
}

/// A link's state in words.
pub const fn in_words(state: LinkState) -> &'static str {
    match state {
        LinkState::Opening => "link opening",
        LinkState::Starting => "link starting",
        LinkState::Up => "link up",
        LinkState::Closing => "link closing",
        LinkState::Closed => "link closed",
    }
}
