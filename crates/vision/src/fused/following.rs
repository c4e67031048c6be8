//! One frame of the fused tracker: predict, observe, evaluate, refine, learn.

use barrelman_vocab::{MotionPrior, Picture, Track, VideoFrame};

use super::config::FusedConfig;
use super::evidence::{coasting_confidence, rejected_confidence};
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
/// A less probable box is compared with that of the second peak, which must be more probable by this much.
const DOUBTFUL_PROBABILITY: f32 = 0.7;
const CLEARLY_MORE_PROBABLE: f32 = 0.2;
/// Minimum relative contrast of a frame that is learned from; with less, the target may be hidden.
const MIN_LEARNED_CONTRAST: f32 = 0.15;
/// Two standard deviations of the prediction may reach this share of the search window's side; beyond it the
/// neighbouring windows are evaluated too.
const MAX_UNCERTAINTY_SHARE: f32 = 0.4;

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
        let seconds = target.predict(config, now, prior);
        let visibility = match target.phase {
            Phase::Lost { .. } => {
                self.references.clear();
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
            Phase::Tracking => Track::Tracking(target.report(frame)),
            Phase::Coasting { since } => {
                target.move_to_prediction();
                target.confidence =
                    coasting_confidence(target.last_probability, now.since(since).as_secs_f64());
                Track::Coasting(target.report(frame))
            }
            Phase::Lost { since } | Phase::Confirming { since, .. } => {
                Track::Lost { since, confidence: target.confidence }
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
        if matches!(target.phase, Phase::Confirming { .. }) {
            observation = self.resolve_axis_direction(config, target, picture, observation);
        }
        let observation = self.refine_best_peak(config, target, picture, observation);
        let probability = self.refined.probability;
        let distance_factor = target.distance_factor(&observation);
        let evidence = observation.evidence(config, target);
        // A box at the border may be all that is left of a target that leaves the picture.
        let is_convincing = probability > CONVINCING_PROBABILITY
            && distance_factor <= 1.0
            && observation.relative_contrast(target).is_none_or(|share| share >= CONVINCING_CONTRAST)
            && !target.geometry.touches_border_at(observation.centre);
        let required =
            if is_convincing { config.seen as f32 - CONVINCING_EVIDENCE } else { config.seen as f32 };
        let is_recognised = !matches!(target.phase, Phase::Confirming { .. })
            || self.is_still_recognised(config, target, picture, &observation);
        if evidence < required * distance_factor
            || probability < MIN_PROBABILITY
            || !is_recognised
            || observation.is_colour_absent(target)
        {
            target.confidence = rejected_confidence(&observation, target);
            self.background.clear_reference();
            return if target.is_prediction_in_picture() {
                Visibility::NotVisible
            } else {
                Visibility::OutOfPicture
            };
        }
        (target.confidence, target.last_probability) = (f64::from(probability), f64::from(probability));
        self.refine(config, target, &observation, frame, seconds);
        target.follow_reported_box(self.refined.edges, seconds);
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
        self.first_window.copy_from(&self.window);
        let other = self.refine_observation(config, target, picture, &second);
        if other.probability > refined.probability + CLEARLY_MORE_PROBABLE {
            return second;
        }
        self.window.copy_from(&self.first_window);
        self.refined = refined;
        self.centre_crop(target, picture, &first);
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
