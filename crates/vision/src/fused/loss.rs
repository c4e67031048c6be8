//! What is kept for finding a lost target again.

use barrelman_vocab::Timestamp;

use super::excluded_places::ExcludedPlaces;
use super::extent::Extent;

/// Factor on the confidence of a box that may be a similar object's: of two similar objects, each is as
/// probable.
const DOUBTFUL_SHARE: f64 = 0.5;

/// State of the search for a lost target.
#[derive(Debug, Clone)]
pub(super) struct LossState {
    /// Where and when the target was lost.
    pub(super) lost_at: LossPoint,
    /// Recognition score of the candidate that is being confirmed.
    pub(super) recognition: RecognitionScore,
    /// Scale and proportions in the last frame that was learned from.
    pub(super) reliable_size: (f32, Extent),
    /// Number of frames searched by colour since the loss.
    pub(super) frames_searched: u32,
    /// Index of the next window of the systematic search.
    pub(super) scan_index: u32,
    /// Places of objects that the operator rejected, in the present frame.
    pub(super) excluded: ExcludedPlaces,
}

/// Whether the followed object, or the next candidate, is the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Identity {
    /// It is.
    Sure,
    /// The track was interrupted. Whether similar objects were beside the target is not known yet.
    Unchecked,
    /// It may be a similar object.
    Doubtful,
}

impl Identity {
    /// Factor on the confidence of the box that is followed.
    pub(super) const fn share(self) -> f64 {
        if matches!(self, Self::Sure) { 1.0 } else { DOUBTFUL_SHARE }
    }

    /// The identity of a track that jumps within the picture.
    pub(super) const fn after_jump(self) -> Self {
        if matches!(self, Self::Sure) { Self::Unchecked } else { self }
    }
}

/// Where and when the target was lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LossPoint {
    pub(super) at: Timestamp,
    /// Predicted centre, pixels.
    pub(super) centre: (f32, f32),
    /// Whether the prediction lay in the picture: the target was hidden rather than out of view.
    pub(super) is_in_picture: bool,
    /// Whether a gap in the video came since the target was seen.
    pub(super) is_in_gap: bool,
}

/// Mean score of the observations of a candidate: how well it is recognised as the target.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RecognitionScore {
    /// Number of observations.
    pub(super) observations: u32,
    /// Mean of height of the response, similarity of the colours and similarity of their layout, each
    /// relative to its usual value: about 3 for the target.
    pub(super) mean: f32,
}

impl LossState {
    /// The state of a target that was just selected.
    pub(super) fn new(now: Timestamp, centre: (f32, f32), extent: Extent) -> Self {
        Self {
            lost_at: LossPoint { at: now, centre, is_in_picture: false, is_in_gap: false },
            recognition: RecognitionScore::default(),
            reliable_size: (1.0, extent),
            frames_searched: 0,
            scan_index: 0,
            excluded: ExcludedPlaces::default(),
        }
    }
}

impl RecognitionScore {
    /// The mean with one more observation.
    pub(super) fn with(self, score: f32) -> Self {
        let observations = self.observations.saturating_add(1);
        Self { observations, mean: self.mean + (score - self.mean) / observations as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recognition_score_is_the_mean_of_its_observations() {
        let first = RecognitionScore::default().with(2.5);
        assert_eq!(first, RecognitionScore { observations: 1, mean: 2.5 });
        let third = first.with(2.25).with(2.0);
        assert!((third.mean - 2.25).abs() < 1e-6 && third.observations == 3, "{third:?}");
    }
}
