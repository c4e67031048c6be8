//! What the tracker says of the target: seen, carried on, lost, perhaps found again.
//!
//! ```text
//!                    seen                                        seen
//!                  +------+                                    +------+
//!                  v      |   not seen                         v      | (fewer than `confirm` times in a row)
//!  selection --> Seen ----+------------> Coasting            Confirming
//!                  ^                      |   |               ^   |   |
//!                  |  seen                |   | longer than   |   |   | not seen
//!                  +----------------------+   | `coast_s`, or |   |   v
//!                  |                          | out of the    |   |
//!                  |                          | picture       |   |
//!                  |                          +---------> Lost ---+
//!                  |   seen `confirm` times more            found anywhere
//!                  +--------------------------------------- (from Confirming)
//! ```
//!
//! `Seen` is reported as tracking, `Coasting` as coasting, both others as lost: what was perhaps found again is not
//! yet believed.

use barrelman_vocab::Timestamp;

/// A state and what is known in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Seen in the last frame.
    Seen,
    /// Not seen; carried on by prediction.
    Coasting {
        /// The first frame in which it was not seen.
        since: Timestamp,
    },
    /// Nowhere to be seen.
    Lost {
        /// The first frame for which that was said.
        since: Timestamp,
    },
    /// Perhaps found again.
    Confirming {
        /// When it was lost.
        since: Timestamp,
        /// In how many frames in a row it was seen since it was found.
        seen: u32,
    },
}

/// What a frame showed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sight {
    /// The target is there.
    Seen,
    /// It is not where it was looked for, but its place can be predicted.
    Unseen,
    /// It is not there, and the prediction lies outside the picture.
    Gone,
}

impl Phase {
    /// The state after a frame.
    pub(crate) fn after(self, sight: Sight, now: Timestamp, coast_s: f64, confirm: u32) -> Self {
        match (self, sight) {
            (Self::Seen | Self::Coasting { .. }, Sight::Seen) => Self::Seen,
            (Self::Seen, Sight::Unseen) if coast_s > 0.0 => Self::Coasting { since: now },
            // Where times run backwards, the wait begins anew.
            (Self::Coasting { since }, Sight::Unseen) if now.since(since).as_secs_f64() < coast_s => {
                Self::Coasting { since: since.min(now) }
            }
            (Self::Seen | Self::Coasting { .. }, Sight::Unseen | Sight::Gone) => Self::Lost { since: now },
            (Self::Lost { since }, Sight::Seen) => Self::confirmed(since, 0, confirm),
            (Self::Confirming { since, seen }, Sight::Seen) => Self::confirmed(since, seen + 1, confirm),
            (Self::Lost { since } | Self::Confirming { since, .. }, Sight::Unseen | Sight::Gone) => {
                Self::Lost { since }
            }
        }
    }

    const fn confirmed(since: Timestamp, seen: u32, confirm: u32) -> Self {
        if seen >= confirm { Self::Seen } else { Self::Confirming { since, seen } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COAST_S: f64 = 0.4;
    const CONFIRM: u32 = 2;

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_secs_f64(seconds)
    }

    fn check(before: Phase, sight: Sight, now_s: f64, expected: Phase) {
        assert_eq!(
            before.after(sight, at(now_s), COAST_S, CONFIRM),
            expected,
            "{before:?} {sight:?} at {now_s} s"
        );
    }

    #[test]
    fn every_edge_of_the_diagram() {
        let coasting = Phase::Coasting { since: at(1.0) };
        let lost = Phase::Lost { since: at(2.0) };
        let confirming = |seen| Phase::Confirming { since: at(2.0), seen };
        check(Phase::Seen, Sight::Seen, 1.0, Phase::Seen);
        check(Phase::Seen, Sight::Unseen, 1.0, coasting);
        check(Phase::Seen, Sight::Gone, 2.0, lost);
        check(coasting, Sight::Seen, 1.2, Phase::Seen);
        check(coasting, Sight::Unseen, 1.3, coasting);
        check(coasting, Sight::Unseen, 1.5, Phase::Lost { since: at(1.5) });
        check(coasting, Sight::Gone, 1.1, Phase::Lost { since: at(1.1) });
        check(lost, Sight::Unseen, 3.0, lost);
        check(lost, Sight::Gone, 3.0, lost);
        check(lost, Sight::Seen, 3.0, confirming(0));
        check(confirming(0), Sight::Seen, 3.0, confirming(1));
        check(confirming(1), Sight::Seen, 3.0, Phase::Seen);
        check(confirming(1), Sight::Unseen, 3.0, lost);
        check(confirming(0), Sight::Gone, 3.0, lost);
    }

    #[test]
    fn without_coasting_and_confirming_there_are_two_states() {
        assert_eq!(Phase::Seen.after(Sight::Unseen, at(1.0), 0.0, 0), Phase::Lost { since: at(1.0) });
        assert_eq!(Phase::Lost { since: at(1.0) }.after(Sight::Seen, at(2.0), 0.0, 0), Phase::Seen);
    }
}
