//! The time of day of the program's times, from pings: the program counts from its own start.
//!
//! A ping is sent at wall time a. Its pong says the program's time p, and arrives at b. The program's start
//! was at (a + b) / 2 - p, to half of b - a. The estimate is that of the fastest ping of late. It stays until
//! a ping contradicts it, so that all messages about one video frame have the same time.

use std::collections::VecDeque;

use crate::messages::Time;

/// Pings that are kept. They come once a second: a change of the path is followed within this number of
/// seconds.
const KEPT: usize = 16;
/// An estimate is not corrected by less, nanoseconds.
const TOLERANCE: i128 = 1_000_000;

/// An answered ping.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Sample {
    /// Wall time of the program's start, nanoseconds since 1970.
    start: i128,
    /// Largest error.
    error: i128,
}

/// The time of day of the program's start.
#[derive(Debug, Default)]
pub struct WallClock {
    samples: VecDeque<Sample>,
    /// The estimate of the program's start.
    start: Option<i128>,
}

impl WallClock {
    /// A ping was answered. The wall times are nanoseconds since 1970.
    pub fn on_pong(&mut self, sent: i128, received: i128, program_ns: u64) {
        if received < sent {
            // The wall clock was set back meanwhile.
            *self = Self::default();
            return;
        }
        let error = (received - sent) / 2;
        let sample = Sample { start: sent + error - i128::from(program_ns), error };
        // What contradicts the new sample is from before a change of the wall clock.
        self.samples.retain(|old| (old.start - sample.start).abs() <= old.error + sample.error);
        if self.samples.len() == KEPT {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
        let is_contradicted = |start: i128| (start - sample.start).abs() > sample.error.max(TOLERANCE);
        if self.start.is_none_or(is_contradicted) {
            self.start = self.samples.iter().min_by_key(|sample| sample.error).map(|best| best.start);
        }
    }

    /// The time of day of a time of the program; `None` before the first answered ping.
    pub fn time_of(&self, program_ns: u64) -> Option<Time> {
        Some(Time::from_nanos(self.start? + i128::from(program_ns)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: i128 = 1_764_000_000_000_000_000;
    const MS: i128 = 1_000_000;

    /// A ping at a time of the program that took so long there and back, milliseconds.
    fn ping(clock: &mut WallClock, start: i128, at_ms: i128, there_ms: i128, back_ms: i128) {
        let at = at_ms * MS;
        clock.on_pong(start + at - there_ms * MS, start + at + back_ms * MS, at as u64);
    }

    #[track_caller]
    fn check(clock: &WallClock, start: i128) {
        let program_ns = 5_000_000_000;
        assert_eq!(clock.time_of(program_ns), Some(Time::from_nanos(start + i128::from(program_ns))));
    }

    #[test]
    fn no_time_of_day_is_known_before_the_first_ping() {
        assert_eq!(WallClock::default().time_of(0), None);
    }

    #[test]
    fn a_faster_ping_corrects_the_estimate_and_a_slower_one_does_not() {
        let mut clock = WallClock::default();
        ping(&mut clock, START, 1000, 30, 10);
        check(&clock, START - 10 * MS);
        ping(&mut clock, START, 2000, 1, 1);
        check(&clock, START);
        for second in 3..40 {
            ping(&mut clock, START, second * 1000, 2, 40);
        }
        check(&clock, START);
    }

    #[test]
    fn a_small_difference_changes_no_time() {
        let mut clock = WallClock::default();
        ping(&mut clock, START, 1000, 2, 4);
        check(&clock, START + MS);
        ping(&mut clock, START, 2000, 1, 1);
        check(&clock, START + MS);
        ping(&mut clock, START - MS, 3000, 1, 1);
        check(&clock, START);
    }

    #[test]
    fn a_wall_clock_that_is_set_is_followed_at_once() {
        let mut clock = WallClock::default();
        ping(&mut clock, START, 1000, 1, 1);
        let later = START + 3_600_000 * MS;
        ping(&mut clock, later, 2000, 4, 4);
        check(&clock, later);
        clock.on_pong(later, later - 1, 0);
        assert_eq!(clock.time_of(0), None, "the wall clock was set back during a ping");
    }
}
