//! When the ticks of a demo are due: at the pace of the clock, and never faster.
//!
//! A world that waits for its pilot may fall behind the clock. A small delay is caught up; a larger one is
//! given up, so that the world runs slower than the clock. [`Pacing::pace`] reports the pace.

use std::time::Duration;

use barrelman_sim::World;
use barrelman_vocab::{PictureSize, Timestamp};

/// A longer delay than this is not caught up.
const MAX_DELAY: Duration = Duration::from_millis(200);
/// The time over which the pace is measured.
const PACE_WINDOW: Duration = Duration::from_secs(2);

/// A world below this pace is slow,
pub const SLOW: f64 = 0.9;
/// and the user is told after so many windows in a row.
const TOLD_AFTER: u32 = 2;
/// The size of pictures that is recommended for a slow machine.
const SMALL: PictureSize = PictureSize::new(640, 360);

/// Paces ticks.
#[derive(Debug, Clone, Copy)]
pub struct Pacing {
    /// A tick and its due time; later ticks are due relative to it.
    reference: (u64, Timestamp),
    /// The start of the measurement of the pace.
    measured_from: (u64, Timestamp),
    pace: f64,
    /// Windows in a row in which the world was slow.
    slow_windows: u32,
}

impl Pacing {
    /// Starts with `tick`, due `now`.
    pub const fn new(tick: u64, now: Timestamp) -> Self {
        Self { reference: (tick, now), measured_from: (tick, now), pace: 1.0, slow_windows: 0 }
    }

    /// When a tick is due. To be called once for each tick, in order.
    pub fn due(&mut self, tick: u64, now: Timestamp) -> Timestamp {
        let elapsed = World::time_of(tick).since(World::time_of(self.reference.0));
        let due = self.reference.1.plus(elapsed);
        if now.since(due) > MAX_DELAY {
            self.reference = (tick, now);
        }
        let measured = now.since(self.measured_from.1);
        if measured >= PACE_WINDOW {
            let simulated = World::time_of(tick).since(World::time_of(self.measured_from.0));
            self.pace = simulated.as_secs_f64() / measured.as_secs_f64();
            self.measured_from = (tick, now);
            self.slow_windows = if self.pace < SLOW { self.slow_windows + 1 } else { 0 };
        }
        due
    }

    /// Continues after a pause, with `tick` due `now`.
    pub const fn resume(&mut self, tick: u64, now: Timestamp) {
        self.reference = (tick, now);
        self.measured_from = (tick, now);
    }

    /// What to tell the user of a world with pictures of this size that has become slow; `None` otherwise.
    pub fn slow_message(&self, size: Option<PictureSize>) -> Option<String> {
        let is_small = size.is_some_and(|size| size.width <= SMALL.width);
        let remedy = if is_small { String::new() } else { format!(". Smaller ones help: --size {SMALL}") };
        (self.slow_windows == TOLD_AFTER).then(|| {
            format!(
                "the simulated world runs slower than real time, at {:.0} % of it: this machine does not render its pictures \
                 in time{remedy}",
                100.0 * self.pace
            )
        })
    }

    /// Simulated seconds per second, over the last two seconds.
    pub const fn pace(&self) -> f64 {
        self.pace
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos(ms * 1_000_000)
    }

    #[test]
    fn ticks_follow_the_clock_and_a_small_delay_is_caught_up() {
        let mut pacing = Pacing::new(0, at(0));
        assert_eq!(pacing.due(120, at(900)), at(1000));
        assert_eq!(pacing.due(132, at(1250)), at(1100));
        assert_eq!(pacing.due(144, at(1250)), at(1200));
    }

    #[test]
    fn a_large_delay_lowers_the_pace_instead() {
        let mut pacing = Pacing::new(0, at(0));
        pacing.due(120, at(3000));
        assert_eq!(pacing.due(240, at(3000)), at(4000));
        assert!((pacing.pace() - 1.0 / 3.0).abs() < 1.0e-9);
        assert_eq!(pacing.slow_message(None), None, "a moment is no news");
        pacing.due(240, at(6000));
        let message = pacing.slow_message(Some(PictureSize::new(1280, 720))).unwrap();
        assert!(message.contains("slower than real time, at 33 %"), "{message}");
        assert!(message.ends_with("Smaller ones help: --size 640x360"), "{message}");
        let message = pacing.slow_message(Some(SMALL)).unwrap();
        assert!(message.ends_with("in time"), "{message}");
        pacing.due(360, at(9000));
        assert_eq!(pacing.slow_message(None), None, "once is enough");
    }
}
