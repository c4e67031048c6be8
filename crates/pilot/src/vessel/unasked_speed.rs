//! Motion of the boat that nobody commands: no throttle is commanded, and the boat reports that its drive goes
//! on.
//!
//! A boat that has just been made neutral runs out, and one that floats drifts with current and wind: neither
//! is a fault. What its drive makes does not get slower, or gets faster: a boat at more than
//! [`MIN_SPEED_M_PER_S`] that has less than [`MIN_LOSS`] of its speed lost over [`SPAN`]. The speed is that
//! over ground, of a boat that reports one.

use core::time::Duration;
use std::collections::VecDeque;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Timestamp, VesselCommand};

/// A slower boat may be one that drifts.
pub const MIN_SPEED_M_PER_S: f64 = 1.5;
/// A boat that runs out loses at least this share of its speed over [`SPAN`]: one whose speed halves within 4
/// s loses 0.16.
pub const MIN_LOSS: f64 = 0.12;
/// Over which time speeds are compared.
pub const SPAN: Duration = Duration::from_millis(1_000);
/// From the command to its effect on the reported speed.
const REACTION: Duration = Duration::from_millis(500);
/// Speeds are kept if they were reported at least this far apart.
const SPACING: Duration = Duration::from_millis(90);
/// Number of speeds that are kept.
const KEPT: usize = 24;

/// Compares the reported speed with a command without throttle.
#[derive(Debug, Clone)]
pub(super) struct UnaskedSpeed {
    newest: VecDeque<(Timestamp, f64)>,
    neutral_since: Option<Timestamp>,
    /// Whether somebody else steers.
    is_anothers: bool,
    moving: Option<f64>,
}

impl UnaskedSpeed {
    pub(super) fn new() -> Self {
        Self { newest: VecDeque::with_capacity(KEPT), neutral_since: None, is_anothers: false, moving: None }
    }

    /// The speed of a boat that moves although no throttle is commanded, m/s.
    pub(super) const fn moving(&self) -> Option<f64> {
        self.moving
    }

    /// A command is in force from now on; `None`: the boat is not commanded. A boat that was found moving is
    /// watched also after it was released.
    pub(super) fn on_command(&mut self, command: Option<VesselCommand>, now: Timestamp) {
        match command {
            Some(command) if command.throttle == 0.0 => {
                self.neutral_since.get_or_insert(now);
            }
            None if self.moving.is_some() => {}
            _ => (self.neutral_since, self.moving) = (None, None),
        }
    }

    /// Takes a report of the vessel.
    pub(super) fn on_report(&mut self, report: &Report, at: Timestamp) {
        match *report {
            Report::Link(LinkState::Opening) => self.newest.clear(),
            Report::Acceptance(said) => {
                // Somebody else steers a boat in another mode, and nothing moves one that is not armed.
                self.is_anothers = said != Acceptance::Accepted && said != Acceptance::Unanswered;
                if self.is_anothers {
                    self.moving = None;
                }
            }
            Report::Speed(speed_m_per_s) => self.on_speed(speed_m_per_s, at),
            _ => {}
        }
    }

    fn on_speed(&mut self, speed_m_per_s: f64, at: Timestamp) {
        match self.newest.back() {
            Some((last, _)) if at < *last => self.newest.clear(),
            Some((last, _)) if at.since(*last) < SPACING => return,
            _ => {}
        }
        if self.newest.len() == KEPT {
            self.newest.pop_front();
        }
        self.newest.push_back((at, speed_m_per_s));
        let Some(since) = self.neutral_since.filter(|_| !self.is_anothers) else { return };
        if speed_m_per_s <= MIN_SPEED_M_PER_S {
            self.moving = None;
            return;
        }
        let from = since.plus(REACTION);
        let before = self.newest.iter().rev().find(|(before, _)| at.since(*before) >= SPAN);
        if let Some((_, speed)) =
            before.filter(|(before, _)| *before >= from && at.since(*before) <= SPAN * 2)
        {
            self.moving = (speed_m_per_s > speed * (1.0 - MIN_LOSS)).then_some(speed_m_per_s);
        } else if self.moving.is_some() {
            self.moving = Some(speed_m_per_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rudder_does_not_hide_a_drive_that_goes_on() {
        let ms = |ms: u64| Timestamp::ZERO.plus(Duration::from_millis(ms));
        for (command, is_found) in [
            (VesselCommand { throttle: 0.0, rudder: 0.5 }, true),
            (VesselCommand { throttle: 0.2, rudder: 0.0 }, false),
        ] {
            let mut speed = UnaskedSpeed::new();
            for now in (0..3_000).step_by(100).map(ms) {
                speed.on_command(Some(command), now);
                speed.on_report(&Report::Speed(3.0), now);
            }
            assert_eq!(speed.moving().is_some(), is_found, "{command:?}");
        }
    }
}
