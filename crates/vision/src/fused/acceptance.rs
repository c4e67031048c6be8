//! The stage that decides whether a candidate is the target, and whether the frame is one to learn from.
//!
//! Input: the candidate with the prediction. Output: a [`Verdict`]. The stage has no state.

use super::config::FusedConfig;
use super::geometry::TargetGeometry;
use super::observation::{Candidate, Observation};
use super::prediction::Prediction;

/// Settings of the decision. The required evidence is set by the user: `seen` and `learn`. Settings without a
/// figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct AcceptanceSettings {
    /// Minimum probability of an accepted candidate's box, 0 to 1.
    min_probability: f32,
    /// A candidate near the prediction that has the target's colour needs less evidence if its box is more
    /// probable than this, 0 to 1.
    convincing_probability: f32,
    /// Minimum relative contrast of a candidate that has the target's colour in this sense, 0 to 1.
    convincing_contrast: f32,
    /// Reduction of the required evidence in this case, in the unit of the evidence.
    convincing_evidence: f32,
    /// Minimum probability of a *trusted* box, 0 to 1. A trusted box lies near the prediction and wholly in
    /// the picture. Its candidate needs as little evidence, and may lack the target's colour. Without, tracks
    /// were lost that had boxes of 0.7 to 0.9 (decision 22).
    trusted_probability: f32,
    /// Maximum distance of a trusted box from the prediction, sizes. If the target is hidden, filter and
    /// network may agree on a similar object farther away.
    trusted_distance_sizes: f32,
    /// Added to that distance, standard deviations of the prediction.
    trusted_distance_deviations: f32,
    /// Distance from the prediction up to which the required evidence does not rise, standard deviations of
    /// the prediction. Beyond this distance, up to twice the evidence is required.
    free_distance_deviations: f64,
    /// Added to that distance, sizes.
    free_distance_sizes: f64,
    /// A candidate without the target's colour is rejected if the usual contrast is higher than this, 0 to 1.
    clear_contrast: f32,
    /// The colour is absent if the relative contrast is lower than this, 0 to 1.
    max_absent_colour: f32,
    /// Minimum relative height of a response that identifies the target's pattern in any colour. A change of
    /// the light or of the camera's white balance changes all colours within a second.
    clear_pattern: f32,
    /// Minimum relative contrast of a frame that is learned from, 0 to 1. With less contrast the target may
    /// be hidden.
    min_learned_contrast: f32,
}

impl Default for AcceptanceSettings {
    fn default() -> Self {
        Self {
            min_probability: 0.05,
            convincing_probability: 0.4,
            convincing_contrast: 0.3,
            convincing_evidence: 6.0,
            trusted_probability: 0.7,
            trusted_distance_sizes: 0.25,
            trusted_distance_deviations: 2.0,
            free_distance_deviations: 3.0,
            free_distance_sizes: 0.5,
            clear_contrast: 0.35,
            max_absent_colour: 0.08,
            clear_pattern: 0.9,
            min_learned_contrast: 0.15,
        }
    }
}

/// The decision about a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Verdict {
    pub(super) is_accepted: bool,
    /// Whether the target is visible enough for filter and colours to learn from the frame.
    pub(super) is_well_visible: bool,
    /// Whether the candidate is so far from the prediction that more evidence is required.
    pub(super) is_far: bool,
}

/// The inputs of a decision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evaluation<'a> {
    pub(super) candidate: &'a Candidate,
    pub(super) prediction: &'a Prediction,
    pub(super) geometry: &'a TargetGeometry,
    /// Usual contrast of the target's colour.
    pub(super) usual_contrast: f32,
    /// Whether a lost target is being confirmed.
    pub(super) is_confirming: bool,
    /// Whether the candidate that is being confirmed still matches the target; `true` otherwise.
    pub(super) is_recognised: bool,
}

/// How much the refined box of a candidate counts against weak evidence of filter and colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trust {
    None,
    /// Less evidence is needed.
    Some,
    /// Less evidence is needed, and the target's colour may be missing.
    Full,
}

/// The decision.
#[derive(Debug)]
pub(super) struct Acceptance {
    config: FusedConfig,
    settings: AcceptanceSettings,
}

impl Acceptance {
    pub(super) fn new(config: &FusedConfig) -> Self {
        Self { config: *config, settings: AcceptanceSettings::default() }
    }

    /// Decides about a candidate.
    pub(super) fn judge(&self, evaluation: &Evaluation<'_>) -> Verdict {
        let Candidate { observation, refined } = evaluation.candidate;
        let distance_factor = self.distance_factor(evaluation);
        let is_far = distance_factor > 1.0;
        let trust = self.trust(evaluation, is_far);
        let relief = if trust == Trust::None { 0.0 } else { self.settings.convincing_evidence };
        let required = self.config.seen as f32 - relief;
        let is_accepted = !(observation.evidence < required * distance_factor
            || refined.probability < self.settings.min_probability
            || !evaluation.is_recognised
            || trust != Trust::Full && self.is_colour_absent(observation, evaluation.usual_contrast));
        // A clear pattern in other colours is the target in another light. The colour model has to learn the
        // new colours.
        let is_well_visible = observation.evidence >= self.config.learn as f32 * distance_factor
            && (observation.has_its_colour(self.settings.min_learned_contrast)
                || self.is_pattern_clear(observation));
        Verdict { is_accepted, is_well_visible, is_far }
    }

    /// How much the refined box counts against weak evidence. `is_far`: see [`Verdict`].
    fn trust(&self, evaluation: &Evaluation<'_>, is_far: bool) -> Trust {
        let settings = &self.settings;
        let Evaluation { candidate, prediction, geometry, .. } = *evaluation;
        let (observation, probability) = (&candidate.observation, candidate.refined.probability);
        // A box at the border may show the last part of a target that leaves the picture.
        if geometry.touches_border_at(observation.centre) {
            return Trust::None;
        }
        let has_its_colour = observation.has_its_colour(settings.convincing_contrast);
        let allowed = settings.trusted_distance_sizes * geometry.size_px()
            + settings.trusted_distance_deviations * prediction.std_dev;
        if probability >= settings.trusted_probability
            && prediction.distance_of(observation) <= allowed
            && !evaluation.is_confirming
        {
            Trust::Full
        } else if probability > settings.convincing_probability && has_its_colour && !is_far {
            Trust::Some
        } else {
            Trust::None
        }
    }

    /// Factor on the evidence required of a candidate, 1 to 2: larger far from the prediction.
    fn distance_factor(&self, evaluation: &Evaluation<'_>) -> f32 {
        let Evaluation { candidate, prediction, geometry, .. } = *evaluation;
        let allowed = self.settings.free_distance_deviations * f64::from(prediction.std_dev)
            + self.settings.free_distance_sizes * f64::from(geometry.size_px());
        let excess = f64::from(prediction.distance_of(&candidate.observation)) / allowed - 1.0;
        (1.0 + 0.5 * excess.clamp(0.0, 2.0)) as f32
    }

    /// Whether the response is about as high as usual for the target.
    fn is_pattern_clear(&self, observation: &Observation) -> bool {
        observation.relative_height >= self.settings.clear_pattern
    }

    /// Whether a usually distinct colour is absent and the pattern is not clear. Then the filter responds to
    /// another object, such as one that hides the target.
    fn is_colour_absent(&self, observation: &Observation, usual_contrast: f32) -> bool {
        usual_contrast > self.settings.clear_contrast
            && !self.is_pattern_clear(observation)
            && observation.relative_contrast.is_some_and(|share| share < self.settings.max_absent_colour)
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{PictureSize, PixelBox};

    use super::super::prediction::CameraShift;
    use super::super::test_target::{observation_at, red_on_blue, selected};
    use super::*;
    use crate::refinement::RefinedBox;

    /// The trust in a box of this probability, seen `right` pixels beside the place of a boat of 30 x 12
    /// pixels, with its colour or without.
    fn trust(probability: f32, right: f32, has_colour: bool, is_confirming: bool) -> Trust {
        let is_boat = |column, row| (100..130).contains(&column) && (60..72).contains(&row);
        let boat = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };
        let (follower, _) = selected(red_on_blue((240, 160), is_boat), boat);
        let (u, v) = follower.target.geometry.centre;
        let relative_contrast = Some(if has_colour { 1.0 } else { 0.0 });
        let observation = Observation { relative_contrast, ..observation_at((u + right, v)) };
        let candidate =
            Candidate { observation, refined: RefinedBox { probability, ..RefinedBox::default() } };
        let evaluation = Evaluation {
            candidate: &candidate,
            prediction: &follower.motion.prediction(),
            geometry: &follower.target.geometry,
            usual_contrast: 0.8,
            is_confirming,
            is_recognised: true,
        };
        let is_far = follower.acceptance.distance_factor(&evaluation) > 1.0;
        follower.acceptance.trust(&evaluation, is_far)
    }

    #[test]
    fn a_probable_box_near_the_prediction_is_trusted_without_its_colour() {
        assert_eq!(trust(0.75, 0.0, false, false), Trust::Full);
        assert_eq!(trust(0.65, 0.0, false, false), Trust::None, "not probable enough without its colour");
        assert_eq!(trust(0.65, 0.0, true, false), Trust::Some);
        assert_eq!(trust(0.35, 0.0, true, false), Trust::None);
        assert_eq!(trust(0.75, 60.0, false, false), Trust::None, "far from the prediction");
        assert_eq!(trust(0.75, 0.0, false, true), Trust::None, "a candidate of the search");
        assert_eq!(trust(0.75, -114.0, true, false), Trust::None, "at the border of the picture");
    }

    #[test]
    fn a_distinct_colour_is_missing_only_where_the_pattern_is_not_clear() {
        let acceptance = Acceptance::new(&FusedConfig::default());
        let distinct = acceptance.settings.clear_contrast + 0.1;
        let is_missing = |usual_contrast, relative_contrast, relative_height| {
            let observation =
                Observation { relative_contrast, relative_height, ..observation_at((0.0, 0.0)) };
            acceptance.is_colour_absent(&observation, usual_contrast)
        };
        assert!(is_missing(distinct, Some(0.0), 0.5), "something else hides the target");
        assert!(!is_missing(distinct, Some(0.0), 1.0), "the target in another light");
        assert!(!is_missing(distinct, Some(0.5), 0.5), "the colour is there");
        assert!(!is_missing(distinct - 0.2, Some(0.0), 0.5), "a colour like the water's");
        assert!(!is_missing(distinct, None, 0.5), "the colour is not used");
    }

    #[test]
    fn far_from_the_prediction_twice_the_evidence_is_required() {
        let acceptance = Acceptance::new(&FusedConfig::default());
        let geometry = TargetGeometry::new((160.0, 120.0), (20.0, 20.0), PictureSize::new(320, 240));
        let prediction =
            Prediction { position: (160.0, 120.0), std_dev: 1.0, camera_shift: CameraShift::Unknown };
        let is_accepted = |right: f32, evidence: f32| {
            let observation = Observation { evidence, ..observation_at((160.0 + right, 120.0)) };
            let refined = RefinedBox { probability: 0.3, ..RefinedBox::default() };
            let verdict = acceptance.judge(&Evaluation {
                candidate: &Candidate { observation, refined },
                prediction: &prediction,
                geometry: &geometry,
                usual_contrast: 0.8,
                is_confirming: false,
                is_recognised: true,
            });
            verdict.is_accepted
        };
        assert!(is_accepted(0.0, 9.1) && !is_accepted(0.0, 8.9));
        assert!(is_accepted(60.0, 18.1) && !is_accepted(60.0, 17.9));
    }
}
