//! Whether a guard hangs: a guard that runs says so every 50 ms, whatever else it does.
//!
//! A plain struct without clock and pipe. The silence is counted in the watcher's own looks, and one look
//! counts for at most [`LONGEST_LOOK`]: a machine that lets neither run, or a program that was stopped
//! itself, has not seen the guard hang. So the guard gets the time to speak before it is judged.

use std::time::Duration;

use barrelman_vocab::Timestamp;

/// A guard says at least this often that it runs.
pub const BEAT: Duration = Duration::from_millis(50);
/// A guard that is silent for this time hangs: three beats are missed. The port's writes are bounded by less,
/// and the next guard has the rest of the 300 ms for its start and its first zeros.
pub const HUNG_AFTER: Duration = Duration::from_millis(180);
/// The same while the guard opens its port: a connection, or a name that is looked up.
/// A name server that does not answer costs five seconds before the next one is asked.
pub const HUNG_WHILE_REOPENING: Duration = Duration::from_secs(7);
/// The same for the first guard of a run: no rate is in force yet, and names and several addresses take their
/// time.
pub const HUNG_WHILE_OPENING: Duration = Duration::from_secs(15);
/// The same until its first word.
pub const HUNG_AT_START: Duration = Duration::from_secs(3);
/// The program looks at least this often.
pub const LOOK_INTERVAL: Duration = Duration::from_millis(20);
/// What one look adds to the silence, at most.
const LONGEST_LOOK: Duration = Duration::from_millis(40);

/// What a guard is busy with, as it said last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// It has said nothing yet.
    Starting,
    /// It opens its port, which may take seconds.
    Opening,
    /// It serves its port.
    Serving,
}

/// The watch over one guard.
#[derive(Debug, Clone, Copy)]
pub struct GuardWatch {
    phase: Phase,
    looked_at: Timestamp,
    silent_for: Duration,
    patience_while_opening: Duration,
}

impl GuardWatch {
    /// The watch over a guard that is started now.
    pub const fn start(patience_while_opening: Duration, now: Timestamp) -> Self {
        Self { phase: Phase::Starting, looked_at: now, silent_for: Duration::ZERO, patience_while_opening }
    }

    /// How long the guard may be busy with its port from now on.
    pub const fn set_patience_while_opening(&mut self, patience: Duration) {
        self.patience_while_opening = patience;
    }

    /// The guard said something, and serves its port.
    pub const fn heard(&mut self) {
        (self.phase, self.silent_for) = (Phase::Serving, Duration::ZERO);
    }

    /// The guard said that it begins to open its port.
    pub const fn heard_opening(&mut self) {
        (self.phase, self.silent_for) = (Phase::Opening, Duration::ZERO);
    }

    /// Whether the guard has said nothing at all yet.
    pub const fn is_starting(&self) -> bool {
        matches!(self.phase, Phase::Starting)
    }

    /// Whether the guard hangs, after everything that it said until now was heard.
    pub fn hangs(&mut self, now: Timestamp) -> bool {
        self.silent_for += now.since(self.looked_at).min(LONGEST_LOOK);
        self.looked_at = now;
        let patience = match self.phase {
            Phase::Starting => HUNG_AT_START,
            Phase::Opening => self.patience_while_opening,
            Phase::Serving => HUNG_AFTER,
        };
        self.silent_for > patience
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos(ms * 1_000_000)
    }

    /// The first look, at an interval, that finds the guard hung, ms after `from`.
    fn hung_after(mut watch: GuardWatch, from: u64, interval: u64) -> u64 {
        (1..).map(|look| look * interval).find(|ms| watch.hangs(at(from + ms))).unwrap_or(0)
    }

    #[test]
    fn a_silent_guard_is_found_in_time() {
        let mut watch = GuardWatch::start(HUNG_WHILE_REOPENING, at(0));
        assert_eq!(hung_after(watch, 0, 20), 3_020);
        watch.heard_opening();
        assert_eq!(hung_after(watch, 0, 20), 7_020);
        watch.set_patience_while_opening(Duration::from_secs(1));
        assert_eq!(hung_after(watch, 0, 20), 1_020);
        watch.heard();
        assert_eq!(hung_after(watch, 0, 20), 200);
    }

    #[test]
    fn a_guard_that_beats_is_left_alone() {
        let mut watch = GuardWatch::start(HUNG_WHILE_REOPENING, at(0));
        for ms in (0..10_000).step_by(20) {
            if ms % 160 == 0 {
                watch.heard();
            }
            assert!(!watch.hangs(at(ms)));
        }
    }

    #[test]
    fn a_program_that_did_not_run_itself_has_seen_no_guard_hang() {
        let mut watch = GuardWatch::start(HUNG_WHILE_REOPENING, at(0));
        watch.heard();
        assert!(!watch.hangs(at(20)));
        assert!(!watch.hangs(at(5_000)), "the program was stopped");
        assert!(!watch.hangs(at(10_000)), "and again");
        assert_eq!(hung_after(watch, 10_000, 20), 100, "the silence itself is not forgotten");
    }
}
