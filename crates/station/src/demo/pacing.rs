//! When the ticks of a demo are due: as fast as the clock goes, and never faster.
//!
//! A world that waits for its pilot may fall behind. A little is made up for; where it is more, the world goes slower
//! than the clock for good, and how fast it goes is told.

use std::time::Duration;

use barrelman_sim::World;
use barrelman_vocab::Timestamp;

/// Arrears beyond this are not made up for.
const MAX_ARREARS: Duration = Duration::from_millis(200);
/// The time over which the pace is told.
const PACE_WINDOW: Duration = Duration::from_secs(2);

/// Paces ticks.
#[derive(Debug, Clone, Copy)]
pub struct Pacing {
    /// This tick was due at this time.
    since: (u64, Timestamp),
    counted_from: (u64, Timestamp),
    pace: f64,
}

impl Pacing {
    /// From `tick` on, at `now`.
    pub const fn from(tick: u64, now: Timestamp) -> Self {
        Self { since: (tick, now), counted_from: (tick, now), pace: 1.0 }
    }

    /// When a tick is due. Asked once for each, in order.
    pub fn due(&mut self, tick: u64, now: Timestamp) -> Timestamp {
        let spent = World::time_of(tick).since(World::time_of(self.since.0));
        let due = self.since.1.plus(spent);
        if now.since(due) > MAX_ARREARS {
            self.since = (tick, now);
        }
        let counted = now.since(self.counted_from.1);
        if counted >= PACE_WINDOW {
            let ticks = World::time_of(tick).since(World::time_of(self.counted_from.0));
            self.pace = ticks.as_secs_f64() / counted.as_secs_f64();
            self.counted_from = (tick, now);
        }
        due
    }

    /// Goes on after a pause.
    pub const fn resume(&mut self, tick: u64, now: Timestamp) {
        self.since = (tick, now);
        self.counted_from = (tick, now);
    }

    /// Simulated seconds in each second, over the last two.
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
    fn ticks_come_by_the_clock_and_small_arrears_are_made_up_for() {
        let mut pacing = Pacing::from(0, at(0));
        assert_eq!(pacing.due(120, at(900)), at(1000));
        assert_eq!(pacing.due(132, at(1250)), at(1100));
        assert_eq!(pacing.due(144, at(1250)), at(1200));
    }

    #[test]
    fn large_arrears_make_it_slower_instead() {
        let mut pacing = Pacing::from(0, at(0));
        pacing.due(120, at(3000));
        assert_eq!(pacing.due(240, at(3000)), at(4000));
        assert!((pacing.pace() - 1.0 / 3.0).abs() < 1.0e-9);
    }
}
