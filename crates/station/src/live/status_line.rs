//! The content of the status line: mode, track, P, rates sent, link, alarm, frame rate, age of the frame.
//!
//! What matters most comes first: a terminal shows as much of the line as fits.
//!
//! [`StatusLine`] formats the newest snapshot and decides when a line is due; it has no clock and does no
//! output.

use std::time::Duration;

use barrelman_console_server::snapshot::{Alarm, LinkStatus, RecordingState, Snapshot, link_state_text};
use barrelman_pilot::Mode;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{CameraCommand, Named as _, Timestamp, Track};

/// Shows status lines.
pub trait StatusOutput {
    /// Shows a line, or drops it. Must not block.
    fn show(&self, line: String);
}

/// When a status line is due.
#[derive(Debug)]
pub struct StatusLine {
    interval: Duration,
    /// Whether the line names the key that changes the mode.
    names_keys: bool,
    next_at: Timestamp,
}

impl StatusLine {
    /// A status line that is due once per `interval`.
    pub const fn new(interval: Duration) -> Self {
        Self { interval, names_keys: false, next_at: Timestamp::ZERO }
    }

    /// The same line with the key that changes the mode, for a terminal whose keys are read.
    #[must_use]
    pub const fn naming_keys(self, names_keys: bool) -> Self {
        Self { names_keys, ..self }
    }

    /// The line, if one is due at `now`.
    pub fn next_line(&mut self, snapshot: &Snapshot, now: Timestamp) -> Option<String> {
        if now < self.next_at {
            return None;
        }
        self.next_at = now.plus(self.interval);
        Some(line(snapshot, now, self.names_keys))
    }
}

/// The key that an operator needs in a mode.
const fn key_of(mode: Mode) -> &'static str {
    match mode {
        Mode::Idle | Mode::Stopped(_) => " (e engages)",
        Mode::Servoing | Mode::Holding(_) | Mode::Nudging | Mode::Searching | Mode::Calibrating => {
            " (space stops)"
        }
    }
}

fn line(snapshot: &Snapshot, now: Timestamp, names_keys: bool) -> String {
    let outcome = snapshot.outcome.as_ref();
    let mode = outcome.map_or_else(
        || "waiting for video".to_owned(),
        |outcome| format!("{}{}", outcome.mode, if names_keys { key_of(outcome.mode) } else { "" }),
    );
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
    let video = &snapshot.video;
    let age = video.age.map_or_else(|| "-".to_owned(), |age| format!("{:.0} ms", age.as_secs_f64() * 1e3));
    let (link, is_up) = match snapshot.vehicle.link {
        LinkStatus::DryRun => ("dry run", false),
        LinkStatus::Simulated => ("simulated camera", true),
        LinkStatus::Link(state) => (link_state_text(state), state == LinkState::Up),
    };
    // Why commands are not accepted tells more than the state of the link.
    let link = match snapshot.vehicle.acceptance {
        Some(said) if said != Acceptance::Accepted => said.text(),
        Some(_) | None => link,
    };
    let alarm = match &snapshot.recording {
        RecordingState::Failed(reason) => format!("  ALARM: {}: {reason}", Alarm::RecordingFailed.text()),
        RecordingState::Off | RecordingState::On(_) => String::new(),
    };
    let sent = if is_up { "" } else { " (not sent)" };
    let rates =
        outcome.map_or(CameraCommand::REST, |outcome| snapshot.rates.in_the_senses_of(outcome.command));
    format!(
        "{mode} | {track} | P {p} | pan {:+.2} tilt {:+.2} rad/s{sent}{advised} | {link}{alarm} | {:.0} fps, age {age}, dropped {}",
        rates.pan.radians_per_second(),
        rates.tilt.radians_per_second(),
        video.fps,
        video.dropped,
    )
}
