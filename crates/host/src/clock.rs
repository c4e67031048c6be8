//! The program's clock: the monotonic clock of the machine, counted from the program's start.
//!
//! `main` starts one [`Clock`] and passes a copy to every thread that needs the time. Nothing else reads
//! `Instant::now`, so that any two timestamps of one run can be compared. The clock does not know the time of
//! day. It stands still while the machine is suspended.

use std::time::{Duration, Instant};

use barrelman_vocab::time::Timestamp;

/// A clock that counts from the program's start.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    start: Instant,
    start_on_monotonic_ns: u64,
}

impl Clock {
    /// A clock that starts now.
    pub fn start() -> Self {
        let start_on_monotonic_ns = monotonic_ns();
        Self { start: Instant::now(), start_on_monotonic_ns }
    }

    /// The clock of another program on the same machine, which started at this moment of `CLOCK_MONOTONIC`,
    /// nanoseconds.
    pub fn started_at(start_on_monotonic_ns: u64) -> Self {
        let age = Duration::from_nanos(monotonic_ns().saturating_sub(start_on_monotonic_ns));
        let now = Instant::now();
        Self { start: now.checked_sub(age).unwrap_or(now), start_on_monotonic_ns }
    }

    /// The clock with an earlier start, for tests of code that depends on the time since the start.
    #[must_use]
    pub fn started_earlier(self, by: Duration) -> Self {
        Self { start: self.start.checked_sub(by).unwrap_or(self.start), ..self }
    }

    /// The time now.
    pub fn now(self) -> Timestamp {
        self.at(Instant::now())
    }

    /// A moment of the machine's clock as a timestamp; 0 for a moment before the start.
    pub fn at(self, moment: Instant) -> Timestamp {
        Timestamp::ZERO.plus(moment.saturating_duration_since(self.start))
    }

    /// A timestamp as a moment of the machine's clock.
    pub fn instant(self, at: Timestamp) -> Instant {
        self.start + at.since(Timestamp::ZERO)
    }

    /// The program's start on `CLOCK_MONOTONIC`, nanoseconds. It relates this program's timestamps to those
    /// of another program on the same machine.
    pub const fn start_on_monotonic_ns(self) -> u64 {
        self.start_on_monotonic_ns
    }
}

fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    // CLOCK_MONOTONIC counts from the machine's start, so neither part is negative.
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timestamp_and_its_instant_are_the_same_moment() {
        let clock = Clock::start();
        let at = Timestamp::from_nanos(1_234_567_890);
        assert_eq!(clock.at(clock.instant(at)), at);
    }

    #[test]
    fn two_programs_have_the_same_time() {
        let first = Clock::start().started_earlier(Duration::from_secs(3));
        let first = Clock { start_on_monotonic_ns: first.start_on_monotonic_ns() - 3_000_000_000, ..first };
        let second = Clock::started_at(first.start_on_monotonic_ns());
        let (before, now, after) = (first.now(), second.now(), first.now());
        let room = Duration::from_millis(1);
        assert!(before.since(Timestamp::ZERO) <= now.since(Timestamp::ZERO) + room);
        assert!(now.since(Timestamp::ZERO) <= after.since(Timestamp::ZERO) + room);
    }

    #[test]
    fn the_start_on_the_monotonic_clock_is_before_now() {
        let clock = Clock::start();
        assert!(clock.start_on_monotonic_ns() > 0 && clock.start_on_monotonic_ns() <= monotonic_ns());
    }
}
