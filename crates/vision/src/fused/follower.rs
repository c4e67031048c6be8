//! The stages of one followed object, and the operations on several stages: a selection, a loss, a jump.
//!
//! A stage owns its settings, its buffers and its state. Plain data flows between the stages: the [`Target`],
//! predictions, observations, candidates, verdicts. `fused` runs the stages in each frame.

use std::sync::Arc;

use barrelman_vocab::{Localisation, PictureSize, PixelBox, Timestamp, VideoFrame};

use super::acceptance::Acceptance;
use super::confidence::Confidence;
use super::config::FusedConfig;
use super::detector::Detector;
use super::exchange::{Exchange, ExchangedTarget};
use super::geometry::TargetGeometry;
use super::identity::IdentityCheck;
use super::known_scene::KnownScene;
use super::later_axis::LaterAxis;
use super::learned_target::LearnedTarget;
use super::learning::Learning;
use super::observation::Observation;
use super::phase::Phase;
use super::prediction::TargetMotion;
use super::recognition::{LossPoint, Recognition};
use super::reported_box::ReportedBox;
use super::search::Search;
use super::seen_axis::SeenAxis;
use super::selection::{BoxChoice, Selection, SelectionColours};
use super::shape::Shape;
use super::target::Target;
use super::views::EarlierViews;
use crate::explanation::{Explanation, TrackerState};
use crate::heading::HeadingEstimator;
use crate::refinement::{RefinedBox, RefinementWeights};

/// Follows an object: state and stages, in the order of a frame.
#[derive(Debug)]
pub(super) struct Follower {
    pub(super) config: FusedConfig,
    pub(super) phase: Phase,
    pub(super) target: Target,
    /// Confidence of the last frame, 0 to 1.
    pub(super) confidence: f64,
    pub(super) selection: Selection,
    pub(super) identity: IdentityCheck,
    pub(super) motion: TargetMotion,
    pub(super) detector: Detector,
    pub(super) views: EarlierViews,
    pub(super) recognition: Recognition,
    pub(super) acceptance: Acceptance,
    pub(super) judgement: Confidence,
    pub(super) shape: Shape,
    pub(super) heading: HeadingEstimator,
    pub(super) reported: ReportedBox,
    pub(super) exchange: Exchange,
    pub(super) learning: Learning,
    pub(super) search: Search,
    pub(super) scene: KnownScene,
    /// Rotation of the patches and the target's axis before the candidate that is being confirmed, radians.
    pub(super) rotation_before_candidate: (f32, f32),
}

/// The result of a selection.
#[derive(Debug, Clone, Copy)]
pub(super) struct SelectedTarget {
    /// The box that is used, pixels.
    pub(super) used: PixelBox,
    /// The network's answer for that box.
    refined: RefinedBox,
    pub(super) colours: SelectionColours,
}

impl Follower {
    /// The stages before [`Self::select`].
    pub(super) fn new(config: &FusedConfig, weights: Arc<RefinementWeights>) -> Self {
        let learning = Learning::new(config);
        let geometry = TargetGeometry::new((0.0, 0.0), (1.0, 1.0), PictureSize::new(0, 0));
        Self {
            config: *config,
            phase: Phase::Lost { since: Timestamp::ZERO },
            target: Target { geometry, appearance: learning.unknown_appearance(), reference: None },
            confidence: 0.0,
            selection: Selection::default(),
            identity: IdentityCheck::new(),
            motion: TargetMotion::new(config.agility),
            detector: Detector::new(config, weights),
            views: EarlierViews::new(),
            recognition: Recognition::new(config),
            acceptance: Acceptance::new(config),
            judgement: Confidence::new(),
            shape: Shape::default(),
            heading: HeadingEstimator::default(),
            reported: ReportedBox::default(),
            exchange: Exchange::default(),
            learning,
            search: Search::new(),
            scene: KnownScene::default(),
            rotation_before_candidate: (0.0, 0.0),
        }
    }

    /// Begins to follow the object in a box that the operator dragged. The refined box is used if the dragged
    /// one is clearly too large or displaced, or if the silhouette agrees with the refined box only.
    pub(super) fn select(&mut self, frame: &VideoFrame, dragged: PixelBox) -> SelectedTarget {
        let first = self.select_box(frame, dragged);
        let bounds = first.refined.bounds().clipped(frame.picture.size());
        if let Some(painted) = self.selection.painted_box(&self.detector.observer.crop, dragged, bounds) {
            return self.select_box(frame, painted);
        }
        match self.selection.choose(dragged, &first.refined, bounds, self.target.reference.is_some()) {
            BoxChoice::Dragged => first,
            BoxChoice::Refined => self.select_box(frame, bounds),
            BoxChoice::RefinedWithSilhouette => {
                let tightened = self.select_box(frame, bounds);
                if self.target.reference.is_some() {
                    return tightened;
                }
                // Windows and references must be those of the used box.
                self.select_box(frame, dragged)
            }
        }
    }

    /// Begins to follow the object in a box, and refines the box.
    fn select_box(&mut self, frame: &VideoFrame, used: PixelBox) -> SelectedTarget {
        let (picture, now) = (&*frame.picture, frame.capture.at);
        let middle = used.centre();
        let centre = (middle.u as f32, middle.v as f32);
        let box_size = (used.w as f32, used.h as f32);
        let geometry = TargetGeometry::new(centre, box_size, picture.size());
        self.motion.select(now, (middle.u, middle.v), f64::from(geometry.initial_size_px));
        let appearance = self.learning.select_colours(picture, centre, box_size);
        self.target = Target { geometry, appearance, reference: None };
        (self.phase, self.confidence) = (Phase::Tracking, 1.0);
        self.forget_path();
        self.judgement.select(now);
        self.identity.select();
        self.recognition.select(now, centre);
        self.search.select();

        let Detector { observer, refiner, .. } = &mut self.detector;
        let pose = observer.patch_pose(&self.target);
        observer.extract_crop(&self.target, picture, &pose);
        let (colours, paint) = self.selection.measure(&observer.crop, &mut self.target, box_size);
        self.shape = Shape::default();
        self.shape.blob.paint = paint;
        self.learning.select_pattern(&mut self.target, observer, picture, box_size);
        self.views.restart(&self.target.appearance);
        self.motion.set_background_reference(picture, &self.target.geometry);
        refiner.restart();
        let centre = self.target.geometry.centre;
        let refined = refiner.evaluate(&mut observer.crop, &self.target, centre);
        refiner.remember_selection();
        refiner.update_references(&observer.crop, centre, now.as_secs_f64());
        SelectedTarget { used, refined, colours }
    }

    /// Forgets path and surroundings of the target.
    fn forget_path(&mut self) {
        self.heading = HeadingEstimator::default();
        self.reported.restart();
        self.exchange.restart();
        self.scene.clear();
    }

    /// Converts the state to pixels of a picture of another size with the same field of view. A picture
    /// without pixels is ignored.
    pub(super) fn adopt_picture_size(&mut self, picture: PictureSize) {
        let geometry = &mut self.target.geometry;
        if picture == geometry.picture || picture.width == 0 || picture.height == 0 {
            return;
        }
        let factors = geometry.rescale_to_picture(picture);
        self.learning.rescale(factors);
        self.motion.rescale(factors);
        self.reported.rescale(factors);
        self.exchange.restart();
        self.scene.clear();
        self.heading.reset();
    }

    /// Makes the target a lost one if a frame that was captured `now` comes after a gap in the video. Target
    /// or camera may have moved in the gap, so that the prediction does not distinguish the target from
    /// similar objects.
    pub(super) fn lose_in_gap(&mut self, now: Timestamp) {
        if self.motion.is_after_gap(now, self.config.coast_s) {
            if !matches!(self.phase, Phase::Lost { .. }) {
                self.mark_lost(false);
            }
            let lost_at = &mut self.recognition.lost_at;
            (lost_at.is_in_picture, lost_at.is_in_gap) = (false, true);
            self.phase = self.phase.after_gap(now);
        }
    }

    /// Records where the target was lost, and restores its last reliable size.
    pub(super) fn mark_lost(&mut self, is_in_picture: bool) {
        self.identity.add_loss();
        self.search.restart();
        let lost_at = LossPoint::out_of_picture(self.motion.last_capture, self.motion.position());
        self.recognition.lost_at = LossPoint { is_in_picture, ..lost_at };
        self.learning.restore_reliable_size(&mut self.target.geometry);
    }

    /// Drops a candidate that was not confirmed. The search continues with the rotation before the candidate,
    /// and with the last reliable size.
    pub(super) fn drop_candidate(&mut self) {
        let geometry = &mut self.target.geometry;
        (geometry.patch_angle, geometry.axis) = self.rotation_before_candidate;
        self.learning.restore_reliable_size(geometry);
    }

    /// What has been learned of the target.
    pub(super) fn learned(&self) -> LearnedTarget {
        LearnedTarget {
            target: self.target.clone(),
            window_memory: self.detector.refiner.memory.clone(),
            paint: self.shape.blob.paint,
            judgement: self.judgement,
        }
    }

    /// Searches everywhere for the target as it was selected. Returns the stages that continue to follow the
    /// rejected object.
    pub(super) fn begin_search(&mut self, selected: &LearnedTarget) -> Self {
        let searching = Self::new(&self.config, self.detector.refiner.weights());
        let mut rejected = core::mem::replace(self, searching);
        self.restore(selected);
        self.adopt_picture_size(rejected.target.geometry.picture);
        // The explanation shows the last search window until the next frame.
        core::mem::swap(&mut self.detector.observer, &mut rejected.detector.observer);
        self.motion = rejected.motion.clone();
        self.motion.restart_at(rejected.motion.position(), &self.target.geometry);
        self.mark_lost(false);
        self.phase = Phase::Lost { since: self.motion.last_capture };
        rejected.motion.clear_background_reference();
        rejected.detector.refiner.clear_references();
        rejected
    }

    /// Restores the target as it was selected.
    fn restore(&mut self, selected: &LearnedTarget) {
        self.target = selected.target.clone();
        self.detector.refiner.memory = selected.window_memory.clone();
        self.shape.blob.paint = selected.paint;
        self.judgement = selected.judgement;
        self.views.restart(&self.target.appearance);
        self.learning.keep_size(&self.target.geometry);
    }

    /// Continues from an observation elsewhere in the search window. Keeps the other objects around the
    /// target.
    pub(super) fn continue_at(&mut self, observation: &Observation) {
        self.detector.refiner.clear_references();
        self.jump_to(observation);
        self.heading.clear_path();
    }

    /// Continues from an observation of a re-detected target.
    pub(super) fn restart_at(&mut self, observation: &Observation) {
        let present = self.detector.observer.patch_pose(&self.target);
        let geometry = &mut self.target.geometry;
        geometry.rescale(observation.pose.step / present.step);
        geometry.axis = geometry.axis_in(&observation.pose);
        geometry.patch_angle = observation.pose.angle;
        self.jump_to(observation);
        self.shape.blob.restart();
        self.shape.later_axis = LaterAxis::default();
        self.exchange.restart();
        self.heading.reset();
    }

    /// Moves the target to an observation at another place, with zero velocity and without a reported box.
    fn jump_to(&mut self, observation: &Observation) {
        let geometry = &mut self.target.geometry;
        geometry.centre = geometry.box_centre_at(observation.centre);
        self.motion.restart_at(geometry.centre, geometry);
        self.reported.restart();
        self.judgement.restart();
    }

    /// Moves the track from another object back onto the target, and retrains the filter there. The network
    /// has not evaluated the box there yet.
    pub(super) fn move_onto(&mut self, exchanged: &ExchangedTarget, frame: &VideoFrame) {
        let geometry = &mut self.target.geometry;
        if let Some((scale, extent)) = exchanged.shape {
            (geometry.scale, geometry.extent) = (scale, extent);
        }
        (geometry.centre, geometry.offset) = (exchanged.centre, (0.0, 0.0));
        self.motion.restart_at(geometry.centre, geometry);
        self.heading.clear_path();
        self.shape.blob.restart();
        self.reported.restart();
        self.learning.retrain(&mut self.target, &mut self.detector.observer, &frame.picture);
        self.judgement.restart();
        self.confidence = self.judgement.settings.unjudged;
    }

    /// Moves the target to the predicted position. The own box of a target with a silhouette is reported
    /// there, since the network's last box may show only the part that was not hidden yet.
    pub(super) fn move_to_prediction(&mut self) {
        self.target.geometry.centre = self.motion.position();
        if self.target.reference.is_some() {
            self.reported.restart();
        }
    }

    /// Adds the target's motion over the water since its centre was at `before` to the heading's path.
    pub(super) fn add_motion(&mut self, before: (f32, f32), at_s: f64, seconds: f64) {
        let geometry = &self.target.geometry;
        let Some(shift) = self.motion.prediction().camera_shift.known() else {
            self.heading.clear_path();
            return;
        };
        let (du, dv) = (geometry.centre.0 - before.0 - shift.0, geometry.centre.1 - before.1 - shift.1);
        let Some(axis) = self.shape.axis(geometry) else { return };
        let length = f64::from(axis.sides.0.max(axis.sides.1));
        let moved = (f64::from(du), f64::from(dv));
        let source = self.motion.camera_motion_source();
        self.heading.add_motion(at_s, seconds, moved, f64::from(axis.angle), length, source);
    }

    /// The localisation to report for a frame.
    pub(super) fn report(&self, frame: &VideoFrame) -> Localisation {
        let bounds = self.reported.bounds(&self.target.geometry).clipped(frame.picture.size());
        self.localisation(frame, bounds, self.confidence)
    }

    /// A localisation with these bounds and confidence.
    pub(super) fn localisation(&self, frame: &VideoFrame, bounds: PixelBox, confidence: f64) -> Localisation {
        let axis = self.shape.axis(&self.target.geometry);
        let centre = self.reported.hull_centre(&self.target, &self.heading);
        let shape = axis.map(SeenAxis::shape);
        let bow = axis.zip(self.heading.is_bow_at_axis_end());
        Localisation {
            captured: frame.capture.at,
            picture: frame.picture.size(),
            centre,
            bounds,
            shape,
            heading: bow.map(|(axis, is_at_end)| axis.heading(is_at_end)),
            confidence,
        }
    }

    /// Keeps the view of a frame that will be learned from, if the view is new. `probability` is that of the
    /// box.
    pub(super) fn keep_view(&mut self, probability: f32) {
        let spectra = &self.detector.observer.features.spectra;
        self.views.keep_if_new(&self.target.appearance, spectra, probability);
    }

    /// Writes the explanation of the last answer; `out` is empty.
    pub(super) fn explain(&self, out: &mut Explanation) {
        self.detector.observer.explain(out);
        out.state = Some(match self.phase {
            Phase::Tracking => TrackerState::Tracking,
            Phase::Coasting { .. } => TrackerState::Coasting,
            Phase::Lost { .. } => TrackerState::Lost,
            Phase::Confirming { .. } => TrackerState::Confirming,
        });
        out.confidence = self.confidence;
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_target::{red_on_blue, selected};
    use super::*;

    #[test]
    fn the_size_before_a_loss_is_that_in_a_picture_of_another_size() {
        let is_boat = |column, row| (100..130).contains(&column) && (60..72).contains(&row);
        let boat = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };
        let (mut follower, _) = selected(red_on_blue((240, 160), is_boat), boat);
        let learned = follower.learned();
        let before = follower.target.geometry.size_px();
        follower.adopt_picture_size(PictureSize::new(960, 640));
        follower.drop_candidate();
        assert!((follower.target.geometry.size_px() / before - 4.0).abs() < 0.01);
        follower.begin_search(&learned);
        assert!((follower.target.geometry.size_px() / before - 4.0).abs() < 0.01);
    }
}
