//! The stage that finds the target around its prediction: the observer proposes peaks of the filter's
//! response, and the refinement network judges their boxes.
//!
//! Input: the target's model, the prediction and the picture. Output: a [`Candidate`]. Afterwards the crop
//! and the window are those of this candidate.

use std::sync::Arc;

use barrelman_vocab::Picture;

use super::config::FusedConfig;
use super::observation::{Candidate, Observation};
use super::observer::Observer;
use super::prediction::Prediction;
use super::refiner::Refiner;
use super::target::Target;
use crate::refinement::RefinementWeights;

/// Settings of the choice among peaks. Without the second peak, P20 is 0.878 for 0.888 on the 39 clips, and
/// 0.077 for 0.068 are lost. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct DetectorSettings {
    /// A box with a lower probability is compared with that of the second peak, 0 to 1.
    doubtful_probability: f32,
    /// Minimum excess of the probability of the second peak's box over that of the first, 0 to 1.
    clearly_more_probable: f32,
}

impl Default for DetectorSettings {
    fn default() -> Self {
        Self { doubtful_probability: 0.7, clearly_more_probable: 0.2 }
    }
}

/// Observer and refiner, which work on the same crop.
#[derive(Debug)]
pub(super) struct Detector {
    settings: DetectorSettings,
    pub(super) observer: Observer,
    pub(super) refiner: Refiner,
}

impl Detector {
    pub(super) fn new(config: &FusedConfig, weights: Arc<RefinementWeights>) -> Self {
        Self {
            settings: DetectorSettings::default(),
            observer: Observer::new(config),
            refiner: Refiner::new(weights),
        }
    }

    /// Refines the observation. If its box is improbable, the second highest peak is refined as well, and
    /// returned if its box is clearly more probable.
    pub(super) fn refine_best_peak(
        &mut self,
        target: &Target,
        prediction: &Prediction,
        picture: &Picture,
        first: Observation,
    ) -> Candidate {
        let first = self.refine(target, prediction, picture, first);
        if first.refined.probability >= self.settings.doubtful_probability {
            return first;
        }
        let Some(second) = self.observer.observe_second_peak(target, &first.observation) else {
            return first;
        };
        self.refiner.keep_window();
        let second = self.refine(target, prediction, picture, second);
        if second.refined.probability > first.refined.probability + self.settings.clearly_more_probable {
            return second;
        }
        self.return_to(target, picture, &first);
        first
    }

    /// Evaluates the refinement network at an observation.
    pub(super) fn refine(
        &mut self,
        target: &Target,
        prediction: &Prediction,
        picture: &Picture,
        observation: Observation,
    ) -> Candidate {
        let centre = self.observer.centre_crop(target, picture, &observation);
        let distance = prediction.distance_of(&observation);
        self.refiner.set_measurements(target, &observation, centre, distance);
        let refined = self.refiner.evaluate(&mut self.observer.crop, target, centre);
        Candidate { observation, refined }
    }

    /// Restores crop and window of an earlier candidate, whose window was kept.
    pub(super) fn return_to(&mut self, target: &Target, picture: &Picture, candidate: &Candidate) {
        self.refiner.return_to_kept();
        self.observer.centre_crop(target, picture, &candidate.observation);
    }
}
