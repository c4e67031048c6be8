//! The target's state from frame to frame: tracking, coasting, lost, or being confirmed.
//!
//! ```text
//!                  visible                                     visible
//!                  +------+                                    +------+
//!                  v      |  not visible                       v      | (fewer than `confirm` times)
//!  selection -> Tracking -+------------> Coasting            Confirming
//!                  ^                      |   |               ^   |   |
//!                  |  visible             |   | longer than   |   |   | not visible
//!                  +----------------------+   | `coast_s`, or |   |   v
//!                  |                          | out of the    |   |
//!                  |                          | picture       |   |
//!                  |                          +---------> Lost ---+
//!                  |   visible `confirm` times more         found anywhere
//!                  +--------------------------------------- (from Confirming)
//! ```
//!
//! A gap in the video leads from any state to `Lost` (`Follower::lose_in_gap`).
//!
//! `Tracking` is reported as tracking, `Coasting` as coasting, `Lost` and `Confirming` as lost: a re-detected
//! target is reported only once it is confirmed.

use barrelman_vocab::Timestamp;

/// A state with its data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// Visible in the last frame.
    Tracking,
    /// Not visible; its position is predicted.
    Coasting {
        /// Time of capture of the first frame in which the target was not visible.
        since: Timestamp,
    },
    /// Searched for in the whole picture.
    Lost {
        /// Time of capture of the first frame reported as lost.
        since: Timestamp,
    },
    /// A candidate was found and is being confirmed.
    Confirming {
        /// When the target was lost.
        since: Timestamp,
        /// Number of consecutive frames in which the candidate was visible, after the first.
        seen: u32,
    },
}

/// Result of looking for the target in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Visibility {
    /// The target was found.
    Visible,
    /// The target was not found; the prediction lies in the picture.
    NotVisible,
    /// The target was not found; the prediction lies outside the picture.
    OutOfPicture,
}

impl Phase {
    /// The state after a frame captured at `now`. `coast_s` (seconds) and `confirm` are those of the
    /// configuration.
    pub(super) fn after(self, visibility: Visibility, now: Timestamp, coast_s: f64, confirm: u32) -> Self {
        match (self, visibility) {
            (Self::Tracking | Self::Coasting { .. }, Visibility::Visible) => Self::Tracking,
            (Self::Tracking, Visibility::NotVisible) if coast_s > 0.0 => Self::Coasting { since: now },
            // Times that run backwards restart the wait.
            (Self::Coasting { since }, Visibility::NotVisible)
                if now.since(since).as_secs_f64() < coast_s =>
            {
                Self::Coasting { since: since.min(now) }
            }
            (Self::Tracking | Self::Coasting { .. }, Visibility::NotVisible | Visibility::OutOfPicture) => {
                Self::Lost { since: now }
            }
            (Self::Lost { since }, Visibility::Visible) => Self::confirmed(since, 0, confirm),
            (Self::Confirming { since, seen }, Visibility::Visible) => {
                Self::confirmed(since, seen + 1, confirm)
            }
            (
                Self::Lost { since } | Self::Confirming { since, .. },
                Visibility::NotVisible | Visibility::OutOfPicture,
            ) => Self::Lost { since },
        }
    }

    /// Whether the target is seen, or its place is predicted.
    pub(super) const fn is_followed(self) -> bool {
        self.lost_since().is_none()
    }

    /// Whether a candidate is being confirmed.
    pub(super) const fn is_confirming(self) -> bool {
        matches!(self, Self::Confirming { .. })
    }

    /// When a target that is searched for or being confirmed was lost.
    pub(super) const fn lost_since(self) -> Option<Timestamp> {
        match self {
            Self::Tracking | Self::Coasting { .. } => None,
            Self::Lost { since } | Self::Confirming { since, .. } => Some(since),
        }
    }

    /// The state on the first frame after a gap in the video, captured `now`.
    pub(super) const fn after_gap(self, now: Timestamp) -> Self {
        match self.lost_since() {
            None => Self::Lost { since: now },
            Some(since) => Self::Lost { since },
        }
    }

    const fn confirmed(since: Timestamp, seen: u32, confirm: u32) -> Self {
        if seen >= confirm { Self::Tracking } else { Self::Confirming { since, seen } }
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

    fn check(before: Phase, visibility: Visibility, now_s: f64, expected: Phase) {
        assert_eq!(
            before.after(visibility, at(now_s), COAST_S, CONFIRM),
            expected,
            "{before:?} {visibility:?} at {now_s} s"
        );
    }

    #[test]
    fn every_edge_of_the_diagram() {
        let coasting = Phase::Coasting { since: at(1.0) };
        let lost = Phase::Lost { since: at(2.0) };
        let confirming = |seen| Phase::Confirming { since: at(2.0), seen };
        check(Phase::Tracking, Visibility::Visible, 1.0, Phase::Tracking);
        check(Phase::Tracking, Visibility::NotVisible, 1.0, coasting);
        check(Phase::Tracking, Visibility::OutOfPicture, 2.0, lost);
        check(coasting, Visibility::Visible, 1.2, Phase::Tracking);
        check(coasting, Visibility::NotVisible, 1.3, coasting);
        check(coasting, Visibility::NotVisible, 1.5, Phase::Lost { since: at(1.5) });
        check(coasting, Visibility::OutOfPicture, 1.1, Phase::Lost { since: at(1.1) });
        check(lost, Visibility::NotVisible, 3.0, lost);
        check(lost, Visibility::OutOfPicture, 3.0, lost);
        check(lost, Visibility::Visible, 3.0, confirming(0));
        check(confirming(0), Visibility::Visible, 3.0, confirming(1));
        check(confirming(1), Visibility::Visible, 3.0, Phase::Tracking);
        check(confirming(1), Visibility::NotVisible, 3.0, lost);
        check(confirming(0), Visibility::OutOfPicture, 3.0, lost);
    }

    #[test]
    fn without_coasting_and_confirming_there_are_two_states() {
        assert_eq!(
            Phase::Tracking.after(Visibility::NotVisible, at(1.0), 0.0, 0),
            Phase::Lost { since: at(1.0) }
        );
        assert_eq!(
            Phase::Lost { since: at(1.0) }.after(Visibility::Visible, at(2.0), 0.0, 0),
            Phase::Tracking
        );
    }
}
