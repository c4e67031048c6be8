//! Whether a loop was away: it made no turn for a second or more, whatever kept it from that.
//!
//! The machine was suspended (the monotonic clock stands still then), or the process was stopped or frozen,
//! waited for memory or the processor, or one of its turns took too long. What the loop knew before says
//! nothing about the present then.

use std::time::Duration;

use barrelman_vocab::Timestamp;

use crate::suspend::SuspendWatch;

/// A loop without a turn for this time was away. Its turns are at most 0.2 s apart otherwise.
pub const AWAY_AFTER: Duration = Duration::from_secs(1);

/// Detects by a loop's own turns that the loop was away. A plain struct without clock.
#[derive(Debug, Clone, Copy)]
pub struct TurnWatch {
    turned_at: Timestamp,
}

impl TurnWatch {
    /// A watch that counts from now.
    pub const fn start(now: Timestamp) -> Self {
        Self { turned_at: now }
    }

    /// The loop makes a turn. Returns how long it was away, if it was.
    pub fn turn(&mut self, now: Timestamp) -> Option<Duration> {
        let away = now.since(self.turned_at);
        self.turned_at = now;
        (away >= AWAY_AFTER).then_some(away)
    }
}

/// Detects suspensions of the machine, and absences while the machine ran.
#[derive(Debug, Clone, Copy)]
pub struct AbsenceWatch {
    suspend: SuspendWatch,
    turns: TurnWatch,
}

impl AbsenceWatch {
    /// A watch that counts from now.
    pub fn start(now: Timestamp) -> Self {
        Self { suspend: SuspendWatch::start(), turns: TurnWatch::start(now) }
    }

    /// The loop makes a turn. Returns how long it was away, if it was.
    pub fn turn(&mut self, now: Timestamp) -> Option<Duration> {
        match (self.suspend.check(), self.turns.turn(now)) {
            (Some(suspended), away) => Some(suspended + away.unwrap_or_default()),
            (None, away) => away,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_without_a_turn_is_an_absence_and_told_once() {
        let at = |ms: u64| Timestamp::from_nanos(ms * 1_000_000);
        let mut watch = TurnWatch::start(at(0));
        for (ms, away) in
            [(200, None), (1_199, None), (2_199, Some(1_000)), (2_200, None), (7_200, Some(5_000))]
        {
            assert_eq!(watch.turn(at(ms)), away.map(Duration::from_millis), "{ms} ms");
        }
    }
}
