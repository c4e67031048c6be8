//! A session and its vehicle in virtual time, a millisecond after the other.

use barrelman_vocab::ZoomAbility;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::Report;

/// A conversation that goes on by milliseconds.
pub(crate) trait Talk: Sized {
    /// Lets a millisecond pass.
    fn step(&mut self);

    /// What the session has reported.
    fn reports(&self) -> &[Report];

    /// The newest report of what the vehicle says to commands.
    fn acceptance(&self) -> Option<Acceptance> {
        self.reports().iter().rev().find_map(|report| match report {
            Report::Acceptance(said) => Some(*said),
            _ => None,
        })
    }

    /// Whether the camera zooms, as reported last.
    fn zoom(&self) -> ZoomAbility {
        let told = self.reports().iter().rev().find_map(|report| match report {
            Report::Zoom(told) => Some(*told),
            _ => None,
        });
        told.unwrap_or_default()
    }

    /// Goes on for `ms` milliseconds.
    fn run_for(&mut self, ms: u64) {
        for _ in 0..ms {
            self.step();
        }
    }

    /// Goes on until the condition holds, at most for `most_ms` milliseconds; returns the time that it took,
    /// milliseconds.
    fn run_until(&mut self, most_ms: u64, mut condition: impl FnMut(&Self) -> bool) -> Option<u64> {
        for ms in 0..=most_ms {
            if condition(self) {
                return Some(ms);
            }
            self.step();
        }
        None
    }
}
