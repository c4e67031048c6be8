//! The content of the status line: mode, track, P, rates sent, frame rate, age of the frame, link, alarm.
//!
//! [`StatusLine`] collects the content and decides when a line is due; it has no clock and does no output.

use std::collections::VecDeque;
use std::time::Duration;

use barrelman_pilot::Outcome;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Timestamp, Track, VehicleRates};

/// The time over which the frame rate is measured.
const FRAME_RATE_WINDOW: Duration = Duration::from_secs(2);
/// Below this time since the first frame the frame rate is shown as 0, s.
const MIN_MEASURED_S: f64 = 0.2;

/// Shows status lines.
pub trait StatusOutput {
    /// Shows a line, or drops it. Must not block.
    fn show(&self, line: String);
}

/// The content of the status line.
#[derive(Debug)]
pub struct StatusLine {
    interval: Duration,
    next_at: Timestamp,
    first_frame: Option<Timestamp>,
    frames: VecDeque<Timestamp>,
    link: Option<LinkState>,
    dropped: u64,
    age: Option<Duration>,
    alarm: Option<String>,
}

impl StatusLine {
    /// A status line that is due once per `interval`; `link` is `None` for a dry run.
    pub fn new(link: Option<LinkState>, interval: Duration) -> Self {
        Self {
            interval,
            next_at: Timestamp::ZERO,
            first_frame: None,
            frames: VecDeque::new(),
            link,
            dropped: 0,
            age: None,
            alarm: None,
        }
    }

    /// The pilot processed a video frame of this age; `dropped` frames were replaced by newer ones so far.
    pub fn frame(&mut self, now: Timestamp, age: Option<Duration>, dropped: u64) {
        self.age = age;
        self.dropped = dropped;
        self.first_frame.get_or_insert(now);
        self.frames.push_back(now);
        while self.frames.front().is_some_and(|at| now.since(*at) > FRAME_RATE_WINDOW) {
            self.frames.pop_front();
        }
    }

    /// Sets the state of the link.
    pub fn link(&mut self, state: LinkState) {
        self.link = Some(state);
    }

    /// Sets the alarm, which is shown until the end of the run.
    pub fn alarm(&mut self, text: String) {
        self.alarm = Some(text);
    }

    /// The line, if one is due at `now`.
    pub fn next_line(
        &mut self,
        outcome: Option<&Outcome>,
        rates: VehicleRates,
        now: Timestamp,
    ) -> Option<String> {
        if now < self.next_at {
            return None;
        }
        self.next_at = now.plus(self.interval);
        Some(self.line(outcome, rates, now))
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
        let advised = advice.map_or_else(String::new, |advice| {
            format!(
                " (would pan {:+.2} tilt {:+.2})",
                advice.command.pan.radians_per_second(),
                advice.command.tilt.radians_per_second()
            )
        });
        let age = self.age.map_or_else(|| "-".to_owned(), |age| format!("{:.0} ms", age.as_secs_f64() * 1e3));
        let per_second = self.frames_per_second(now);
        let link = self.link.map_or("dry run", link_state_text);
        let sent = if self.link == Some(LinkState::Up) { "" } else { " (not sent)" };
        let alarm = self.alarm.as_ref().map_or_else(String::new, |alarm| format!("  ALARM: {alarm}"));
        format!(
            "{mode} | {track} | P {p} | yaw {:+.2} pitch {:+.2} rad/s{sent}{advised} | {per_second:.0} fps, age {age}, dropped {} | {link}{alarm}",
            rates.yaw.radians_per_second(),
            rates.pitch.radians_per_second(),
            self.dropped,
        )
    }

    fn frames_per_second(&self, now: Timestamp) -> f64 {
        let measured_s =
            self.first_frame.map_or(0.0, |first| now.since(first).min(FRAME_RATE_WINDOW).as_secs_f64());
        if measured_s > MIN_MEASURED_S { self.frames.len() as f64 / measured_s } else { 0.0 }
    }
}

/// The state of a link as text.
pub const fn link_state_text(state: LinkState) -> &'static str {
    match state {
        LinkState::Opening => "link opening",
        LinkState::Starting => "link starting",
        LinkState::Up => "link up",
        LinkState::Closing => "link closing",
        LinkState::Closed => "link closed",
    }
}
