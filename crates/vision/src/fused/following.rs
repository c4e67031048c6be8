//! One frame of the fused tracker: predict, observe, evaluate, refine, learn.

use barrelman_vocab::{MotionPrior, Picture, Track, VideoFrame};

use super::config::FusedConfig;
use super::evidence::{REJECTED_FACTOR, rejected_confidence};
use super::loss::Identity;
use super::observation::Observation;
use super::phase::{Phase, Visibility};
use super::target::Target;
use super::workspace::Workspace;
use crate::features::PatchPose;

/// An observation whose refined box is less probable is rejected.
const MIN_PROBABILITY: f32 = 0.05;
/// With a more probable box near the prediction, at least this relative contrast of the colour, and the whole box in
/// the picture, an observation needs less evidence by this amount.
const CONVINCING_PROBABILITY: f32 = 0.4;
const CONVINCING_CONTRAST: f32 = 0.3;
const CONVINCING_EVIDENCE: f32 = 6.0;
/// From this probability on, a box near the prediction and wholly in the picture is *trusted*: it needs as little evidence, and
/// no contrast. The network reads the colours, too, and a target that turns or drives into the shade shows others.
const TRUSTED_PROBABILITY: f32 = 0.7;
/// Largest distance of a trusted box from the prediction: in sizes of the target, and in standard deviations of the
/// prediction, added. Filter and network together jump to what looks like a hidden target.
const TRUSTED_DISTANCE_SIZES: f32 = 0.25;
const TRUSTED_DISTANCE_DEVIATIONS: f32 = 2.0;
/// A less probable box is compared with that of the second peak, which must be more probable by this much.
const DOUBTFUL_PROBABILITY: f32 = 0.7;
const CLEARLY_MORE_PROBABLE: f32 = 0.2;
/// Confidence of a box onto which the track was moved, and which the network has not seen yet.
const UNJUDGED_CONFIDENCE: f64 = 0.5;

/// Largest confidence of a target that is lost, or found and not confirmed yet.
const MAX_LOST_CONFIDENCE: f64 = REJECTED_FACTOR;
/// Confidence of a box after a contact with a thing of the target's colour, as a share, as long as nothing told which of the two is
/// followed: it was the target in four of five frames.
const DOUBTED_SHARE: f64 = 0.8;
/// Confidence from which on a picture is kept: what else it shows is not the target.
const MIN_SURE_CONFIDENCE: f64 = 0.7;
/// Minimum relative contrast of a frame that is learned from; with less, the target may be hidden.
const MIN_LEARNED_CONTRAST: f32 = 0.15;
/// Two standard deviations of the prediction may reach this share of the search window's side; beyond it the
/// neighbouring windows are evaluated too.
const MAX_UNCERTAINTY_SHARE: f32 = 0.4;

/// How much the refined box of an observation counts against weak evidence of filter and colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trust {
    None,
    /// Less evidence is needed.
    Some,
    /// Less evidence is needed, and the target's colour may be missing.
    Full,
}

impl Trust {
    fn in_observation(target: &Target, observation: &Observation, probability: f32) -> Self {
        // A box at the border may be all that is left of a target that leaves the picture.
        if target.geometry.touches_border_at(observation.centre) {
            return Self::None;
        }
        let has_its_colour =
            observation.relative_contrast(target).is_none_or(|share| share >= CONVINCING_CONTRAST);
        let distance = target.distance_from_prediction(observation);
        let allowed = TRUSTED_DISTANCE_SIZES * target.geometry.size_px()
            + TRUSTED_DISTANCE_DEVIATIONS * target.motion.std_dev();
        let is_followed = !matches!(target.phase, Phase::Confirming { .. });
        if probability >= TRUSTED_PROBABILITY && distance <= allowed && is_followed {
            Self::Full
        } else if probability > CONVINCING_PROBABILITY
            && has_its_colour
            && target.distance_factor(observation) <= 1.0
        {
            Self::Some
        } else {
            Self::None
        }
    }
}

impl Target {
    /// Keeps a picture in which the target is sure, and its identity, too. What was found after a loss is
    /// given up where an earlier picture shows it apart from the target.
    fn compare_with_scene(&mut self, before: Phase, frame: &VideoFrame) {
        let bounds = self.report(frame).bounds;
        match before {
            Phase::Lost { since } | Phase::Confirming { since, .. } => {
                self.identify_found();
                if self.scene.showed(&frame.picture, bounds, self.confidence) {
                    self.scene.exclude(self.geometry.centre);
                    self.phase = Phase::Lost { since };
                    self.confidence = 0.0;
                }
            }
            Phase::Tracking | Phase::Coasting { .. } => {
                if self.confidence >= MIN_SURE_CONFIDENCE && self.identity == Identity::Sure {
                    self.scene.keep(&frame.picture, bounds, self.confidence);
                }
            }
        }
    }
}

impl Workspace {
    /// Processes one frame; the track to report.
    pub(super) fn advance(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        frame: &VideoFrame,
        prior: Option<&MotionPrior>,
    ) -> Track {
        let picture = &*frame.picture;
        let now = frame.capture.at;
        if target.rescale_to_picture(picture.size()) {
            self.background.clear_reference();
        }
        self.check_identity(config, target);
        let seconds = target.predict(config, now, prior);
        target.surroundings.predict(target.geometry.size_px(), seconds as f32);
        let visibility = match target.phase {
            Phase::Lost { .. } => {
                // Only the first frame after a gap has a reference from before.
                let shift = self.background_shift(target, picture);
                self.background.clear_reference();
                self.background.forget_measurement();
                target.motion.add_camera_shift(shift, f64::from(target.geometry.size_px()));
                self.references.clear();
                target.scene.predict(target.motion.camera_shift, seconds as f32);
                let found = self.search_picture(config, target, picture);
                if let Some(observation) = &found {
                    target.restart_at(config, observation);
                }
                if found.is_some() { Visibility::Visible } else { Visibility::NotVisible }
            }
            _ => self.follow(config, target, frame, seconds),
        };
        let before = target.phase;
        target.phase = before.after(visibility, now, config.coast_s, config.confirm);
        if target.phase == Phase::Tracking {
            target.compare_with_scene(before, frame);
        }
        if matches!(target.phase, Phase::Lost { .. }) {
            match before {
                Phase::Tracking | Phase::Coasting { .. } => {
                    target.mark_lost(visibility != Visibility::OutOfPicture);
                }
                Phase::Confirming { .. } => target.restore_reliable_size(),
                Phase::Lost { .. } => {}
            }
        }
        match target.phase {
            Phase::Tracking => {
                target.confidence *= target.identity.share();
                Track::Tracking(target.report(frame))
            }
            Phase::Coasting { .. } => {
                target.move_to_prediction();
                target.confidence = target.probability.of_prediction(now) * target.identity.share();
                Track::Coasting(target.report(frame))
            }
            Phase::Lost { since } | Phase::Confirming { since, .. } => {
                Track::Lost { since, confidence: target.confidence.min(MAX_LOST_CONFIDENCE) }
            }
        }
    }

    /// Looks for the target around its prediction, `seconds` after the last frame, and measures it where it is found.
    fn follow(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        frame: &VideoFrame,
        seconds: f64,
    ) -> Visibility {
        let picture = &*frame.picture;
        let mut observation = self.observe_prediction(config, target, picture);
        let shift = target.motion.is_camera_shift_known.then_some(target.motion.camera_shift);
        self.references.add_background_shift(shift);
        target.scene.predict(target.motion.camera_shift, seconds as f32);
        if matches!(target.phase, Phase::Confirming { .. }) {
            observation = self.resolve_axis_direction(config, target, picture, observation);
        }
        let observation = self.refine_best_peak(config, target, picture, observation);
        let highest = observation;
        let observation = self.reconsider(config, target, picture, observation);
        let probability = self.refined.probability;
        let distance_factor = target.distance_factor(&observation);
        let evidence = observation.evidence(config, target);
        let trust = Trust::in_observation(target, &observation, probability);
        let relief = if trust == Trust::None { 0.0 } else { CONVINCING_EVIDENCE };
        let required = config.seen as f32 - relief;
        let is_recognised = !matches!(target.phase, Phase::Confirming { .. })
            || self.is_still_recognised(config, target, picture, &observation);
        if evidence < required * distance_factor
            || probability < MIN_PROBABILITY
            || !is_recognised
            || trust != Trust::Full && observation.is_colour_absent(target)
        {
            target.confidence = rejected_confidence(&observation, target);
            self.background.clear_reference();
            return if target.is_prediction_in_picture() {
                Visibility::NotVisible
            } else {
                Visibility::OutOfPicture
            };
        }
        target.confidence = target.probability.add(probability, frame.capture.at);
        let is_from_border =
            target.geometry.touches_border() && !target.geometry.touches_border_at(observation.centre);
        if distance_factor > 1.0 || observation != highest || is_from_border {
            target.identity = target.identity.after_jump();
        }
        self.refine(config, target, &observation, frame, seconds);
        target.follow_reported_box(self.refined.edges, seconds);
        if self.correct_exchanged_target(config, target, picture, seconds as f32) {
            target.probability.restart();
            target.confidence = UNJUDGED_CONFIDENCE;
            return Visibility::Visible;
        }
        if target.surroundings.companions.are_in_doubt() {
            target.confidence *= DOUBTED_SHARE;
        }
        let has_its_colour =
            observation.relative_contrast(target).is_none_or(|share| share >= MIN_LEARNED_CONTRAST);
        // A clear pattern in other colours is the target in another light, which the colour model has to learn.
        let is_well_visible = evidence >= config.learn as f32 * distance_factor
            && (has_its_colour || observation.is_pattern_clear(target));
        if target.phase == Phase::Tracking && is_well_visible && !target.geometry.touches_border() {
            self.learn(config, target, picture, &observation);
        }
        self.references.update(&self.crop, target.geometry.centre, frame.capture.at.as_secs_f64());
        Visibility::Visible
    }

    /// Refines the observation. Where its box is doubtful, the second highest peak is refined, too, and taken if its
    /// box is clearly more probable. Crop, window and refined box are those of the observation that is taken.
    fn refine_best_peak(
        &mut self,
        config: &FusedConfig,
        target: &Target,
        picture: &Picture,
        first: Observation,
    ) -> Observation {
        let refined = self.refine_observation(config, target, picture, &first);
        if refined.probability >= DOUBTFUL_PROBABILITY {
            return first;
        }
        let Some(second) = self.observe_second_peak(target, &first) else { return first };
        self.best_window.copy_from(&self.window);
        let other = self.refine_observation(config, target, picture, &second);
        if other.probability > refined.probability + CLEARLY_MORE_PROBABLE {
            return second;
        }
        self.return_to(target, picture, &first, refined);
        first
    }

    /// Observes the window around the prediction, and its neighbours if the prediction is too uncertain. The best
    /// observation, whose crop is the one that is kept.
    fn observe_prediction(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
    ) -> Observation {
        let pose = target.patch_pose(config);
        let side = pose.side_px();
        let shift = self.background_shift(target, picture);
        let pose = PatchPose { centre: target.predicted_centre(shift), ..pose };
        let mut best = self.observe(target, picture, pose);
        if 2.0 * target.motion.std_dev() > MAX_UNCERTAINTY_SHARE * side
            && best.evidence(config, target) < config.learn as f32
        {
            for (right, down) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                let centre = (pose.centre.0 + 0.5 * right * side, pose.centre.1 + 0.5 * down * side);
                let observation = self.observe(target, picture, PatchPose { centre, ..pose });
                if observation.evidence(config, target) > best.evidence(config, target) {
                    best = observation;
                }
            }
            if best.pose != self.pose {
                // The following steps sample the crop of the best observation.
                best = self.observe(target, picture, best.pose);
            }
        }
        best
    }

    /// Shift of the background since the last frame, pixels, where no precise prior gives it.
    fn background_shift(&mut self, target: &Target, picture: &Picture) -> Option<(f32, f32)> {
        if target.motion.has_precise_prior {
            return None;
        }
        self.background.measure_shift(picture.y(), &mut self.features.fourier)
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{PixelBox, Timestamp};

    use super::super::test_target::{red_on_blue, selected};
    use super::*;
    use crate::correlation::Peak;
    use crate::crop::ColourContrast;

    /// The trust in a box of this probability, seen `right` pixels beside the place of a boat of 30 x 12 pixels, with its colour or
    /// without.
    fn trust(probability: f32, right: f32, has_colour: bool, is_confirming: bool) -> Trust {
        let config = FusedConfig::default();
        let is_boat = |column, row| (100..130).contains(&column) && (60..72).contains(&row);
        let boat = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };
        let (_, mut target, _) = selected(&config, red_on_blue((240, 160), is_boat), boat);
        if is_confirming {
            target.phase = Phase::Confirming { since: Timestamp::from_nanos(0), seen: 0 };
        }
        let (u, v) = target.geometry.centre;
        let inside = if has_colour { target.appearance.usual.contrast } else { 0.0 };
        let observation = Observation {
            pose: target.patch_pose(&config),
            centre: (u + right, v),
            peak: Peak::default(),
            contrast: ColourContrast { inside, ring: 0.0 },
        };
        Trust::in_observation(&target, &observation, probability)
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
}
