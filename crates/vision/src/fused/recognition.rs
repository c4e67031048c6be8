//! The stage that compares an observation with the lost target: pattern, colours and their layout.
//!
//! Input: an observation with the target's model and the picture. Output: a score, and whether the score is
//! sufficient at its place. State: the place of the loss, and the mean score of the candidate that is being
//! confirmed.

use barrelman_vocab::{Picture, Timestamp};

use super::colour_counts::ColourCounts;
use super::config::FusedConfig;
use super::observation::Observation;
use super::target::Target;
use crate::vector::distance;

/// Settings of the recognition. The minimum evidence is set by the user: `again`. Settings without a figure
/// were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecognitionSettings {
    /// Minimum relative height of the response of a compared observation.
    min_relative_height: f32,
    /// Minimum relative contrast of a compared observation, 0 to 1.
    min_relative_contrast: f32,
    /// Minimum score at the place of a recent loss; the target has about 3. A target that was lost inside the
    /// picture is probably still there, and half hidden.
    min_score_at_loss: f32,
    /// Minimum score elsewhere. An object there must match in all respects.
    min_score_elsewhere: f32,
    /// Reduction of the minimum score for the mean score of a candidate that is being confirmed.
    confirming_slack: f32,
    /// Radius of the place of the loss, sizes.
    loss_radius_sizes: f32,
    /// Duration for which the place of the loss is preferred, seconds.
    loss_preferred_s: f64,
}

impl Default for RecognitionSettings {
    fn default() -> Self {
        Self {
            min_relative_height: 0.3,
            min_relative_contrast: 0.2,
            min_score_at_loss: 1.8,
            min_score_elsewhere: 2.37,
            confirming_slack: 0.07,
            loss_radius_sizes: 1.5,
            loss_preferred_s: 3.0,
        }
    }
}

/// Place and time of the loss of the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LossPoint {
    pub(super) at: Timestamp,
    /// Predicted centre, pixels.
    pub(super) centre: (f32, f32),
    /// Whether the prediction lay in the picture: then the target was hidden, not out of view.
    pub(super) is_in_picture: bool,
    /// Whether the video had a gap since the target was seen.
    pub(super) is_in_gap: bool,
}

impl LossPoint {
    /// A target that is out of the picture at this time and place, not after a gap.
    pub(super) const fn out_of_picture(at: Timestamp, centre: (f32, f32)) -> Self {
        Self { at, centre, is_in_picture: false, is_in_gap: false }
    }
}

/// Mean score of the observations of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RecognitionScore {
    /// Number of observations.
    observations: u32,
    /// Mean of the sum of height of the response, similarity of the colours and similarity of their layout,
    /// each relative to its usual value. The target has about 3.
    pub(super) mean: f32,
}

/// Compares observations with the target; keeps its buffers.
#[derive(Debug)]
pub(super) struct Recognition {
    config: FusedConfig,
    settings: RecognitionSettings,
    counts: ColourCounts,
    pub(super) lost_at: LossPoint,
    /// Score of the candidate that is being confirmed.
    pub(super) score: RecognitionScore,
}

impl Recognition {
    pub(super) fn new(config: &FusedConfig) -> Self {
        Self {
            config: *config,
            settings: RecognitionSettings::default(),
            counts: ColourCounts::default(),
            lost_at: LossPoint::out_of_picture(Timestamp::ZERO, (0.0, 0.0)),
            score: RecognitionScore::default(),
        }
    }

    /// Begins with a selected target, which was not lost yet.
    pub(super) fn select(&mut self, at: Timestamp, centre: (f32, f32)) {
        self.lost_at = LossPoint::out_of_picture(at, centre);
        self.score = RecognitionScore::default();
    }

    /// Score of an observation: the sum of relative height of the response, relative similarity of the
    /// colours and relative similarity of their layout; the target has about 3. `None` if the evidence is too
    /// weak for a comparison.
    pub(super) fn compare(
        &mut self,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
    ) -> Option<f32> {
        let height = observation.relative_height;
        let is_strong = observation.evidence >= self.config.again as f32
            && height >= self.settings.min_relative_height
            && observation.has_its_colour(self.settings.min_relative_contrast);
        is_strong.then(|| height.min(1.0) + self.relative_similarity(target, picture, observation))
    }

    /// Sum of the similarities of the colours and of their layout at an observation to the target's, each
    /// relative to its usual value; the target has about 2.
    fn relative_similarity(&mut self, target: &Target, picture: &Picture, observation: &Observation) -> f32 {
        let Target { geometry, appearance, .. } = target;
        let axis = geometry.axis_in(&observation.pose);
        let pose = geometry.patch_pose(self.config.padding);
        let scale = geometry.scale * observation.pose.step / pose.step;
        self.counts.count(picture, observation.centre, &geometry.extent, scale, axis);
        self.counts.similarity(appearance) / appearance.usual.similarity
            + self.counts.layout_similarity(appearance) / appearance.usual.layout_similarity
    }

    /// Whether an observation of a lost target is recognised in a frame that was captured `now`. A recognised
    /// one is the candidate that will be confirmed.
    pub(super) fn recognise(
        &mut self,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
        now: Timestamp,
    ) -> bool {
        let Some(score) = self.compare(target, picture, observation) else { return false };
        let is_recognised = score >= self.min_score(observation.centre, target.geometry.size_px(), now);
        if is_recognised {
            self.score = RecognitionScore::default().with(score);
        }
        is_recognised
    }

    /// Whether the candidate that is being confirmed is still recognised: by the mean of its observations, so
    /// that a single one may be worse.
    pub(super) fn confirm(
        &mut self,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
        now: Timestamp,
    ) -> bool {
        let Some(score) = self.compare(target, picture, observation) else { return false };
        self.score = self.score.with(score);
        let min = self.min_score(observation.centre, target.geometry.size_px(), now);
        self.score.mean >= min - self.settings.confirming_slack
    }

    /// Minimum score of an observation at a place, pixels, of a target of this size.
    fn min_score(&self, place: (f32, f32), size_px: f32, now: Timestamp) -> f32 {
        if self.is_at_loss(place, size_px, now) {
            self.settings.min_score_at_loss
        } else {
            self.settings.min_score_elsewhere
        }
    }

    /// Minimum mean score of an object elsewhere that could be confirmed as the target.
    pub(super) fn min_confirmed_score(&self) -> f32 {
        self.settings.min_score_elsewhere - self.settings.confirming_slack
    }

    /// Whether a place, pixels, is that of a recent loss within the picture.
    pub(super) fn is_at_loss(&self, place: (f32, f32), size_px: f32, now: Timestamp) -> bool {
        let lost_at = &self.lost_at;
        let is_recent = now.since(lost_at.at).as_secs_f64() <= self.settings.loss_preferred_s;
        lost_at.is_in_picture
            && is_recent
            && distance(place, lost_at.centre) <= self.settings.loss_radius_sizes * size_px
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
