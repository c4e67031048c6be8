//! The default tracker: a correlation filter and a colour model, fused into one measure of evidence, with
//! loss and re-detection.
//!
//! The correlation filter works on gradients, brightness and target probability of the colour, restricted to
//! the target and its close surroundings (`correlation`). The colour model compares the colours at the target
//! with those of the ring around it (`colour_model`). The *evidence* is the sum of both, in standard
//! deviations of the response's sidelobes. The colour is not used where the target's colour resembles that of
//! its surroundings.
//!
//! One frame passes the stages in this order. Each stage is a struct with its settings, its buffers and its
//! state; plain data flows between the stages (`follower`).
//!
//! 1. *Predict*: a Kalman filter in pixel coordinates predicts the target's position (`prediction`). The
//!    camera's motion comes from the [`MotionPrior`], otherwise from registration of the background
//!    (`background`).
//! 2. *Detect*: the search window is extracted at the coarsest resolution that the target's size allows,
//!    rotated and scaled as the target was (`observer`). The observation is the peak of the filter's
//!    response. A network reads a window around the box there, and answers with the edges of the box and its
//!    probability (`refiner`, `detector`). If the box is improbable, filters of earlier views search the
//!    window for the target (`views`).
//! 3. *Accept*: evidence and probability decide whether the candidate is the target (`acceptance`), and how
//!    confident the answer is (`confidence`, `identity`).
//! 4. *Measure*: the filter's responses at other sizes and rotations give size and rotation, the moments of
//!    the colour correct centre and axis, the blob of the paint follows a target that changes its shape
//!    (`shape`), later silhouettes give an axis that the selection did not show (`later_axis`), and the path
//!    distinguishes bow and stern (`heading`). A track that stayed with another object is moved back onto the
//!    target (`exchange`).
//! 5. *Learn*: filter and histograms adapt to the frame if the target is well visible (`learning`).
//!
//! A lost target is searched for by colour in the whole picture, and by the filter at the place of the loss
//! and in one window of a systematic search per frame (`search`). A recognised candidate (`recognition`) is
//! reported once the following frames have confirmed it, unless an earlier picture shows that it is another
//! object (`known_scene`).
//!
//! Work per frame: one search window of at most 130 x 130 samples and about nine small patches, for a target
//! of any size; at most eight search windows while it is lost. Memory: less than 6 MiB for pictures of up to
//! 1920 x 1080 pixels, as much again for each rejected object that is followed (`distractors`), and two
//! earlier video frames that are shared with their source. No allocation per frame once the buffers have
//! their size.
//!
//! Not handled: targets that change beyond recognition while hidden, groups of similar targets that cross,
//! targets smaller than about 6 pixels.

mod config;
mod fused_tracker;

mod follower;

mod selection;

mod acceptance;
mod confidence;
mod detector;
mod exchange;
mod identity;
mod known_scene;
mod later_axis;
mod learned_target;
mod learning;
mod observer;
mod prediction;
mod recognition;
mod refiner;
mod reported_box;
mod search;
mod seen_axis;
mod shape;
mod views;

mod blob;
mod companion;
mod companions;
mod contact;
mod contradiction;
mod distractors;
mod excluded_places;
mod found_object;

mod appearance;
mod colour_counts;
mod extent;
mod geometry;
mod observation;
mod phase;
mod ratio;
mod reference_silhouette;
mod shape_following;
mod target;
mod time_constant;

#[cfg(test)]
mod test_target;

use barrelman_vocab::{MotionPrior, Picture, Track, VideoFrame};

use self::acceptance::{Evaluation, Verdict};
pub use self::config::{FusedConfig, FusedConfigError, FusedSetting};
use self::detector::Detector;
use self::follower::Follower;
pub use self::fused_tracker::FusedTracker;
use self::identity::IdentityInput;
use self::observation::Candidate;
use self::phase::{Phase, Visibility};
use self::prediction::Prediction;
use self::search::SearchInput;

/// A zoom changes the size of objects from one frame to the next by no other factor.
const PLAUSIBLE_SCALES: core::ops::RangeInclusive<f64> = 0.5..=2.0;

impl Follower {
    /// Processes one frame. Returns the track to report.
    fn advance(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track {
        let now = frame.capture.at;
        self.adopt_picture_size(frame.picture.size());
        self.identity.check(IdentityInput {
            observer: &mut self.detector.observer,
            recognition: &mut self.recognition,
            search: &mut self.search,
            scene: &self.scene,
            target: &self.target,
        });
        let seconds = self.motion.predict(now, prior, &self.target.geometry);
        let zoomed = |scale: &f64| *scale != 1.0 && PLAUSIBLE_SCALES.contains(scale);
        if let Some(scale) = prior.map(|prior| prior.scale).filter(zoomed) {
            self.target.geometry.rescale(scale as f32);
        }
        self.exchange.predict(self.target.geometry.size_px(), seconds as f32);
        let visibility = match self.phase {
            Phase::Lost { .. } => self.search_picture(&frame.picture, seconds),
            Phase::Tracking | Phase::Coasting { .. } | Phase::Confirming { .. } => {
                self.follow(frame, seconds)
            }
        };
        let before = self.phase;
        self.phase = before.after(visibility, now, self.config.coast_s, self.config.confirm);
        if self.phase == Phase::Tracking {
            self.compare_with_scene(before, frame);
        }
        if matches!(self.phase, Phase::Lost { .. }) {
            match before {
                Phase::Tracking | Phase::Coasting { .. } => {
                    self.mark_lost(visibility != Visibility::OutOfPicture);
                }
                Phase::Confirming { .. } => self.drop_candidate(),
                Phase::Lost { .. } => {}
            }
        }
        match self.phase {
            Phase::Tracking => {
                self.confidence *= self.identity.share();
                Track::Tracking(self.report(frame))
            }
            Phase::Coasting { .. } => {
                self.move_to_prediction();
                self.confidence = self.judgement.of_prediction(now) * self.identity.share();
                Track::Coasting(self.report(frame))
            }
            Phase::Lost { since } | Phase::Confirming { since, .. } => {
                Track::Lost { since, confidence: self.judgement.of_lost(self.confidence) }
            }
        }
    }

    /// Searches a frame for the lost target, `seconds` after the last frame.
    fn search_picture(&mut self, picture: &Picture, seconds: f64) -> Visibility {
        let prediction = self.motion.predict_lost(picture, &self.target.geometry);
        self.detector.refiner.clear_references();
        self.scene.predict(prediction.camera_shift.estimate(), seconds as f32);
        let input = SearchInput {
            observer: &mut self.detector.observer,
            recognition: &mut self.recognition,
            scene: &mut self.scene,
            confidence: &self.judgement,
            target: &self.target,
            picture,
            now: self.motion.last_capture,
        };
        let found = self.search.run(input, prediction.position);
        self.confidence = found.confidence;
        let Some(observation) = found.observation else { return Visibility::NotVisible };
        let geometry = &self.target.geometry;
        self.rotation_before_candidate = (geometry.patch_angle, geometry.axis);
        self.restart_at(&observation);
        Visibility::Visible
    }

    /// Looks for the target around its prediction, `seconds` after the last frame. Measures the target if it
    /// is found.
    fn follow(&mut self, frame: &VideoFrame, seconds: f64) -> Visibility {
        let (picture, now) = (&*frame.picture, frame.capture.at);
        let prediction = self.motion.measure_shift(picture, &self.target.geometry);
        self.detector.refiner.add_background_shift(prediction.camera_shift.known());
        self.scene.predict(prediction.camera_shift.estimate(), seconds as f32);
        let first = self.detect(picture, &prediction);
        let candidate = self.reconsider(picture, &prediction, first);
        let has_jumped = candidate.observation != first.observation;
        let verdict = self.judge(picture, &candidate);
        if !verdict.is_accepted {
            return self.reject_candidate(&candidate);
        }
        self.confidence = self.judgement.add(candidate.refined.probability, now);
        let geometry = &self.target.geometry;
        let place = candidate.observation.centre;
        let is_from_border = geometry.touches_border() && !geometry.touches_border_at(place);
        if verdict.is_far || has_jumped || is_from_border {
            self.identity.add_jump();
        }
        self.measure(frame, &candidate, seconds);
        self.reported.follow(candidate.refined.edges, &self.target.geometry, seconds);
        let (crop, paint) = (&self.detector.observer.crop, self.shape.blob.paint);
        let exchanged = self.exchange.find(crop, &self.target, paint.is_some(), seconds as f32);
        if let Some(exchanged) = exchanged {
            self.move_onto(&exchanged, frame);
            return Visibility::Visible;
        }
        if self.exchange.is_in_doubt() {
            self.confidence *= self.judgement.settings.contact_share;
        }
        if self.phase == Phase::Tracking && verdict.is_well_visible && !self.target.geometry.touches_border()
        {
            self.learn(picture, &candidate);
        }
        let centre = self.target.geometry.centre;
        let Detector { observer, refiner, .. } = &mut self.detector;
        refiner.update_references(&observer.crop, centre, now.as_secs_f64());
        Visibility::Visible
    }

    /// The most probable candidate around the prediction.
    fn detect(&mut self, picture: &Picture, prediction: &Prediction) -> Candidate {
        let observer = &mut self.detector.observer;
        let mut observation = observer.observe_prediction(&self.target, prediction, picture);
        if self.phase.is_confirming() && self.target.reference.is_some() {
            let (taken, is_reversed) = observer.observe_either_direction(&self.target, picture, observation);
            if is_reversed {
                self.target.geometry.reverse_axis();
            }
            observation = taken;
        }
        self.detector.refine_best_peak(&self.target, prediction, picture, observation)
    }

    /// Looks for the target elsewhere in the search window if the box of the followed candidate is
    /// improbable. The track continues from another place if that is clearly more probable, and no earlier
    /// picture shows the object there apart from the target.
    fn reconsider(&mut self, picture: &Picture, prediction: &Prediction, followed: Candidate) -> Candidate {
        if !self.views.is_doubted(followed.refined.probability) || self.phase.is_confirming() {
            return followed;
        }
        let taken = self.views.reconsider(&mut self.detector, &self.target, prediction, picture, followed);
        if taken.observation == followed.observation {
            return followed;
        }
        let bounds = taken.refined.bounds().clipped(picture.size());
        if self.scene.was_visible_before(picture, bounds, f64::from(taken.refined.probability)) {
            // The following stages sample crop and window of the followed candidate.
            return self.detector.refine(&self.target, prediction, picture, followed.observation);
        }
        self.continue_at(&taken.observation);
        taken
    }

    /// Decides whether a candidate is the target.
    fn judge(&mut self, picture: &Picture, candidate: &Candidate) -> Verdict {
        let now = self.motion.last_capture;
        let is_confirming = self.phase.is_confirming();
        let is_recognised =
            !is_confirming || self.recognition.confirm(&self.target, picture, &candidate.observation, now);
        self.acceptance.judge(&Evaluation {
            candidate,
            prediction: &self.motion.prediction(),
            geometry: &self.target.geometry,
            usual_contrast: self.target.appearance.usual.contrast,
            is_confirming,
            is_recognised,
        })
    }

    /// Handles a frame in which no candidate was accepted.
    fn reject_candidate(&mut self, candidate: &Candidate) -> Visibility {
        self.confidence = self.judgement.of_rejected(&candidate.observation, &self.target);
        self.motion.clear_background_reference();
        if self.motion.is_in_picture(&self.target.geometry) {
            Visibility::NotVisible
        } else {
            Visibility::OutOfPicture
        }
    }

    /// Measures size, rotation, centre and heading of the target at an accepted candidate, `seconds` after
    /// the last frame.
    fn measure(&mut self, frame: &VideoFrame, candidate: &Candidate, seconds: f64) {
        let Candidate { observation, refined } = candidate;
        let (picture, seconds_f32) = (&*frame.picture, seconds as f32);
        let Self { target, shape, heading, learning, .. } = self;
        let Detector { observer, refiner, .. } = &mut self.detector;
        let before = target.geometry.centre;
        let change = observer.measure_pose_change(target, observation);
        target.geometry.centre = target.geometry.box_centre_at(observation.centre);
        // Size and rotation of a target that is partly outside the picture cannot be measured.
        if !target.geometry.touches_border() {
            shape.follow(target, &observer.crop, observation, change, seconds_f32);
            if shape.correct_contradicted_box(target, refined, seconds_f32) {
                learning.retrain(target, observer, picture);
            }
        }
        shape.follow_refined_box(target, refined, &refiner.window, observation.centre);
        if shape.later_axis.follow(&observer.crop, target, change.turn, seconds_f32) {
            heading.reset();
        }
        self.motion.correct(picture, &self.target.geometry);
        self.add_motion(before, frame.capture.at.as_secs_f64(), seconds);
    }

    /// Adapts to a frame in which the target is well visible.
    fn learn(&mut self, picture: &Picture, candidate: &Candidate) {
        let Detector { observer, refiner, .. } = &mut self.detector;
        let pose = observer.patch_pose(&self.target);
        observer.extract_features(&self.target, &pose);
        refiner.remember_usual();
        self.keep_view(candidate.refined.probability);
        let observer = &mut self.detector.observer;
        self.learning.learn(&mut self.target, observer, picture, &candidate.observation);
    }

    /// Keeps the picture if box and identity of the target are certain. Drops an object that was found after
    /// a loss if an earlier picture shows the object apart from the target.
    fn compare_with_scene(&mut self, before: Phase, frame: &VideoFrame) {
        let geometry = &self.target.geometry;
        let bounds = self.reported.bounds(geometry).clipped(frame.picture.size());
        match before {
            Phase::Lost { since } | Phase::Confirming { since, .. } => {
                let now = frame.capture.at;
                let is_at_loss = self.recognition.is_at_loss(geometry.centre, geometry.size_px(), now);
                self.identity.add_found(&self.recognition, is_at_loss);
                if self.scene.was_visible_before(&frame.picture, bounds, self.confidence) {
                    self.scene.exclude(geometry.centre);
                    self.phase = Phase::Lost { since };
                    self.confidence = 0.0;
                }
            }
            Phase::Tracking | Phase::Coasting { .. } => {
                if self.identity.is_sure() {
                    self.scene.keep(&frame.picture, bounds, self.confidence);
                }
            }
        }
    }
}
