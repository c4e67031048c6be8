//! What becomes of a selection of the background.

use barrelman_vision::Tracker;
use barrelman_vocab::Track;
use serde_json::{Value, json};

use super::placement::BackgroundSelection;
use crate::tracker::clips::Clip;
use crate::tracker::tracker_run::{box_numbers, confidence};

/// A track with less confidence claims no target.
pub(super) const MIN_CLAIM: f64 = 0.5;

/// What became of a selection of the background. All but `Wrong` are right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The selection was refused.
    Refused,
    /// The track was lost when it was judged.
    Lost,
    /// The track had a confidence below [`MIN_CLAIM`].
    LowConfidence,
    /// The track claimed a target.
    Wrong,
}

impl Outcome {
    /// The outcome of a track that is judged.
    fn of_track(track: &Track) -> Self {
        match track {
            Track::Unseeded | Track::Lost { .. } => Self::Lost,
            Track::Tracking(localisation) | Track::Coasting(localisation) => {
                if localisation.confidence < MIN_CLAIM { Self::LowConfidence } else { Self::Wrong }
            }
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Refused => "refused",
            Self::Lost => "lost",
            Self::LowConfidence => "low confidence",
            Self::Wrong => "wrong",
        }
    }
}

/// A selection with its outcome.
pub(super) struct JudgedSelection {
    pub(super) selection: BackgroundSelection,
    pub(super) outcome: Outcome,
    /// The confidence when the track was judged, 0 to 1; `None` where the selection was refused.
    pub(super) confidence: Option<f64>,
}

impl JudgedSelection {
    /// Selects, tracks up to the judged frame, and judges.
    pub(super) fn measure(tracker: &mut dyn Tracker, clip: &Clip, selection: BackgroundSelection) -> Self {
        if tracker.select(&clip.frames[selection.frame], selection.bounds).is_err() {
            return Self { selection, outcome: Outcome::Refused, confidence: None };
        }
        let mut track = Track::Unseeded;
        for frame in &clip.frames[selection.frame + 1..=selection.judged] {
            track = tracker.track(frame, None);
        }
        Self { selection, outcome: Outcome::of_track(&track), confidence: confidence(&track) }
    }

    pub(super) fn to_json(&self, source: &str) -> Value {
        json!({
            "clip": source, "frame": self.selection.frame, "box": box_numbers(self.selection.bounds),
            "judged": self.selection.judged, "outcome": self.outcome.name(), "confidence": self.confidence,
        })
    }
}

/// Counts of outcomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Tally {
    pub(super) refused: usize,
    pub(super) lost: usize,
    pub(super) low_confidence: usize,
    pub(super) wrong: usize,
}

impl Tally {
    pub(super) fn of(outcomes: impl Iterator<Item = Outcome>) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            *match outcome {
                Outcome::Refused => &mut tally.refused,
                Outcome::Lost => &mut tally.lost,
                Outcome::LowConfidence => &mut tally.low_confidence,
                Outcome::Wrong => &mut tally.wrong,
            } += 1;
        }
        tally
    }

    /// The number of selections.
    pub(super) const fn count(self) -> usize {
        self.refused + self.lost + self.low_confidence + self.wrong
    }

    /// Share of the right selections, 0 to 1; NaN of none.
    pub(super) fn right_share(self) -> f64 {
        (self.count() - self.wrong) as f64 / self.count() as f64
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{Localisation, PictureSize, PixelBox, Timestamp};

    use super::*;

    #[test]
    fn only_a_confident_track_is_wrong() {
        let at = |confidence| {
            let bounds = PixelBox { u: 0.0, v: 0.0, w: 8.0, h: 6.0 };
            Localisation {
                captured: Timestamp::ZERO,
                picture: PictureSize::new(100, 60),
                centre: bounds.centre(),
                bounds,
                shape: None,
                heading: None,
                confidence,
            }
        };
        for (track, outcome) in [
            (Track::Tracking(at(0.5)), Outcome::Wrong),
            (Track::Coasting(at(0.9)), Outcome::Wrong),
            (Track::Tracking(at(0.49)), Outcome::LowConfidence),
            (Track::Lost { since: Timestamp::ZERO, confidence: 0.9 }, Outcome::Lost),
        ] {
            assert_eq!(Outcome::of_track(&track), outcome, "{track:?}");
        }
    }

    #[test]
    fn all_but_the_wrong_are_right() {
        let outcomes = [Outcome::Refused, Outcome::Lost, Outcome::LowConfidence, Outcome::Wrong];
        let tally = Tally::of(outcomes.into_iter());
        assert_eq!((tally.count(), tally.right_share()), (4, 0.75));
        assert!(Tally::default().right_share().is_nan());
    }
}
