//! The tracker's state of one selected target.

use barrelman_vocab::track::Shape;
use barrelman_vocab::{
    Angle, Localisation, MotionPrior, PictureSize, PixelBox, PixelPoint, Timestamp, VideoFrame,
};

use super::appearance::Appearance;
use super::box_probability::BoxProbability;
use super::config::FusedConfig;
use super::contradiction::Contradiction;
use super::filter_views::FilterViews;
use super::geometry::TargetGeometry;
use super::known_scene::KnownScene;
use super::loss::{Identity, LossPoint, LossState};
use super::observation::Observation;
use super::phase::Phase;
use super::prediction::TargetMotion;
use super::reference_silhouette::ReferenceSilhouette;
use super::shape_following::rate_in;
use super::surroundings::Surroundings;
use super::target_paint::{SeenBlob, TargetPaint};
use crate::features::PatchPose;
use crate::heading::HeadingEstimator;
use crate::refinement::WindowMemory;

/// Minimum recognition score at the place of the loss, and elsewhere.
const MIN_SCORE_AT_LOSS: f32 = 1.8;
pub(super) const MIN_SCORE_ELSEWHERE: f32 = 2.37;
/// Radius of the place of the loss, in sizes of the target, and how long it is preferred, seconds.
const LOSS_RADIUS_SIZES: f32 = 1.5;
const LOSS_PREFERRED_S: f64 = 3.0;

/// Distance from the prediction that needs no more evidence: standard deviations of the prediction, plus sizes of the
/// target. Beyond it, up to twice the evidence is required.
const FREE_DISTANCE_DEVIATIONS: f64 = 3.0;
const FREE_DISTANCE_SIZES: f64 = 0.5;

/// Time constant with which the reported box follows the network's, seconds.
const REPORTED_BOX_S: f64 = 0.05;

/// The target as it was last seen.
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub(super) phase: Phase,
    pub(super) geometry: TargetGeometry,
    pub(super) motion: TargetMotion,
    pub(super) appearance: Appearance,
    /// The silhouette at the selection, if it can be trusted.
    pub(super) reference: Option<ReferenceSilhouette>,
    pub(super) heading: HeadingEstimator,
    pub(super) drift: DriftCheck,
    pub(super) contradiction: Contradiction,
    /// Other things of its colour around it.
    pub(super) surroundings: Surroundings,
    /// Filters of earlier views.
    pub(super) views: FilterViews,
    /// Earlier pictures, and other things that the search has found.
    pub(super) scene: KnownScene,
    /// The paint, if the target has one that sets it apart.
    pub(super) paint: Option<TargetPaint>,
    /// The blob of the paint, if it is followed.
    pub(super) blob: Option<SeenBlob>,
    pub(super) loss: LossState,
    /// Whether the followed object, or the next candidate, is the target.
    pub(super) identity: Identity,
    /// Earlier windows of the refinement network.
    pub(super) memory: WindowMemory,
    /// Edges of the box that is reported, from the centre of the target's own box: left, top, right, bottom, pixels. `None`
    /// until the network saw the target, and while one with a silhouette coasts: then its own box is reported.
    pub(super) reported_edges: Option<[f32; 4]>,
    /// Confidence of the last frame, 0 to 1.
    pub(super) confidence: f64,
    /// Probability of the box, over frames.
    pub(super) probability: BoxProbability,
}

/// Counters of the check for a box that slipped off its target.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct DriftCheck {
    /// Number of frames in which the target was refined.
    pub(super) frames: u32,
    /// Consecutive checks in which the colour lay elsewhere than the box.
    pub(super) misfits: u32,
}

impl Target {
    /// Pose of the search window around the target's last position.
    pub(super) fn patch_pose(&self, config: &FusedConfig) -> PatchPose {
        self.geometry.patch_pose(config.padding)
    }

    /// Converts the state to pixels of a picture of another size with the same field of view; whether it did. A picture
    /// without pixels is ignored.
    pub(super) fn rescale_to_picture(&mut self, picture: PictureSize) -> bool {
        if picture == self.geometry.picture || picture.width == 0 || picture.height == 0 {
            return false;
        }
        let factors = self.geometry.rescale_to_picture(picture);
        self.motion.rescale(factors);
        if let Some([left, top, right, bottom]) = &mut self.reported_edges {
            (*left, *right) = (*left * factors.0, *right * factors.0);
            (*top, *bottom) = (*top * factors.1, *bottom * factors.1);
        }
        self.surroundings = Surroundings::default();
        self.scene = KnownScene::default();
        self.heading.reset();
        true
    }

    /// Predicts the target's position at `now`; the time since the last frame, seconds.
    pub(super) fn predict(
        &mut self,
        config: &FusedConfig,
        now: Timestamp,
        prior: Option<&MotionPrior>,
    ) -> f64 {
        self.motion.predict(now, prior, config.agility, f64::from(self.geometry.size_px()))
    }

    /// Predicts the position of a target that is not looked for there, and so has no measured shift of the background; the time since
    /// the last frame, seconds.
    pub(super) fn predict_unseen(
        &mut self,
        config: &FusedConfig,
        now: Timestamp,
        prior: Option<&MotionPrior>,
    ) -> f64 {
        let seconds = self.predict(config, now, prior);
        self.motion.add_camera_shift(None, f64::from(self.geometry.size_px()));
        seconds
    }

    /// The predicted centre, clamped to the picture, with the measured shift of the background, pixels.
    pub(super) fn predicted_centre(&mut self, background_shift: Option<(f32, f32)>) -> (f32, f32) {
        self.motion.add_camera_shift(background_shift, f64::from(self.geometry.size_px()));
        let picture = self.geometry.picture_size();
        let (u, v) = self.motion.position_f32();
        (u.clamp(0.0, picture.0), v.clamp(0.0, picture.1))
    }

    /// Whether the predicted centre lies in the picture.
    pub(super) fn is_prediction_in_picture(&self) -> bool {
        let picture = self.geometry.picture_size();
        let (u, v) = self.motion.position();
        (0.0..=f64::from(picture.0)).contains(&u) && (0.0..=f64::from(picture.1)).contains(&v)
    }

    /// Distance of an observation's centre from the predicted one, pixels.
    pub(super) fn distance_from_prediction(&self, observation: &Observation) -> f32 {
        let (u, v) = self.motion.position_f32();
        libm::hypotf(observation.centre.0 - u, observation.centre.1 - v)
    }

    /// Factor on the evidence required of an observation, 1 to 2: larger far from the prediction.
    pub(super) fn distance_factor(&self, observation: &Observation) -> f32 {
        let allowed = FREE_DISTANCE_DEVIATIONS * f64::from(self.motion.std_dev())
            + FREE_DISTANCE_SIZES * f64::from(self.geometry.size_px());
        let excess = f64::from(self.distance_from_prediction(observation)) / allowed - 1.0;
        (1.0 + 0.5 * excess.clamp(0.0, 2.0)) as f32
    }

    /// Minimum recognition score of an observation of a lost target. A target that was recently lost inside the picture
    /// is probably still there and half hidden; an object elsewhere must match in every respect.
    pub(super) fn min_recognition_score(&self, observation: &Observation) -> f32 {
        if self.is_at_loss(observation.centre) { MIN_SCORE_AT_LOSS } else { MIN_SCORE_ELSEWHERE }
    }

    /// Whether a place, pixels, is that of a recent loss within the picture.
    pub(super) fn is_at_loss(&self, place: (f32, f32)) -> bool {
        let lost_at = &self.loss.lost_at;
        let away = libm::hypotf(place.0 - lost_at.centre.0, place.1 - lost_at.centre.1);
        let is_recent = self.motion.last_capture.since(lost_at.at).as_secs_f64() <= LOSS_PREFERRED_S;
        lost_at.is_in_picture && is_recent && away <= LOSS_RADIUS_SIZES * self.geometry.size_px()
    }

    /// Records where the target was lost, and restores its last reliable size.
    pub(super) fn mark_lost(&mut self, is_in_picture: bool) {
        let centre = self.motion.position_f32();
        self.identity = Identity::Unchecked;
        self.loss.frames_searched = 0;
        self.loss.lost_at =
            LossPoint { at: self.motion.last_capture, centre, is_in_picture, is_in_gap: false };
        self.restore_reliable_size();
    }

    /// Makes the target a lost one if a frame that was captured `now` comes after a gap in the video. Whatever moved
    /// meanwhile, target or camera, the prediction tells no more which of several objects is the target.
    pub(super) fn lose_in_gap(&mut self, config: &FusedConfig, now: Timestamp) {
        if self.motion.is_after_gap(now, config.coast_s) {
            if !matches!(self.phase, Phase::Lost { .. }) {
                self.mark_lost(false);
            }
            (self.loss.lost_at.is_in_picture, self.loss.lost_at.is_in_gap) = (false, true);
            self.phase = self.phase.after_gap(now);
        }
    }

    /// Makes this target, as it was selected, a lost one that is searched for everywhere, after `rejected` was followed in
    /// its place.
    pub(super) fn begin_search(&mut self, rejected: &Self) {
        self.rescale_to_picture(rejected.geometry.picture);
        self.motion = rejected.motion.clone();
        self.motion.restart_at(rejected.motion.position_f32(), f64::from(self.geometry.size_px()));
        self.heading.reset();
        self.drift = DriftCheck::default();
        self.contradiction = Contradiction::default();
        self.surroundings = Surroundings::default();
        self.scene = KnownScene::default();
        self.reported_edges = None;
        self.mark_lost(false);
        self.phase = Phase::Lost { since: self.motion.last_capture };
        self.confidence = 0.0;
    }

    /// Restores the last reliable size, after a loss or a rejected candidate.
    pub(super) fn restore_reliable_size(&mut self) {
        (self.geometry.scale, self.geometry.extent) = self.loss.reliable_size;
    }

    /// Moves the box that is reported towards the network's box (left, top, right, bottom, pixels), `seconds` after the last
    /// frame. The confidence is that of the network's box; the target's own box, with which the filter works, follows later.
    pub(super) fn follow_reported_box(&mut self, refined: [f32; 4], seconds: f64) {
        let (u, v) = self.geometry.centre;
        let mut edges = [refined[0] - u, refined[1] - v, refined[2] - u, refined[3] - v];
        if let Some(last) = self.reported_edges {
            let rate = rate_in(seconds, REPORTED_BOX_S);
            for (edge, last) in edges.iter_mut().zip(last) {
                *edge = last + rate * (*edge - last);
            }
        }
        self.reported_edges = Some(edges);
    }

    /// Moves the target to the predicted position. What the network saw last of a target with a silhouette may be the part of
    /// it that was not hidden yet: its own box is predicted.
    pub(super) fn move_to_prediction(&mut self) {
        self.geometry.centre = self.motion.position_f32();
        if self.reference.is_some() {
            self.reported_edges = None;
        }
    }

    /// Continues from an observation elsewhere in the search window. What is known of other things around the target stays.
    pub(super) fn continue_at(&mut self, observation: &Observation) {
        self.jump_to(observation);
        self.heading.clear_path();
    }

    /// Continues from an observation of a re-detected target.
    pub(super) fn restart_at(&mut self, config: &FusedConfig, observation: &Observation) {
        self.geometry.rescale(observation.pose.step / self.patch_pose(config).step);
        self.geometry.axis = self.geometry.axis_in(&observation.pose);
        self.geometry.patch_angle = observation.pose.angle;
        self.jump_to(observation);
        self.blob = None;
        self.surroundings = Surroundings::default();
        self.heading.reset();
    }

    /// Moves the target to an observation at another place: at rest, with nothing known of its box there.
    fn jump_to(&mut self, observation: &Observation) {
        self.geometry.centre = self.geometry.box_centre_at(observation.centre);
        self.motion.restart_at(self.geometry.centre, f64::from(self.geometry.size_px()));
        self.reported_edges = None;
        self.probability.restart();
    }

    /// The localisation to report for a frame.
    pub(super) fn report(&self, frame: &VideoFrame) -> Localisation {
        let (u, v) = self.geometry.centre;
        let [left, top, right, bottom] = self.reported_edges.unwrap_or_else(|| {
            let (w, h) = self.geometry.upright_box();
            [-0.5 * w, -0.5 * h, 0.5 * w, 0.5 * h]
        });
        let bounds = PixelBox {
            u: f64::from(u + left),
            v: f64::from(v + top),
            w: f64::from(right - left),
            h: f64::from(bottom - top),
        };
        self.localisation(frame, bounds.clipped(frame.picture.size()), self.confidence)
    }

    /// A localisation with these bounds and confidence.
    pub(super) fn localisation(&self, frame: &VideoFrame, bounds: PixelBox, confidence: f64) -> Localisation {
        let half = self.geometry.half_axes();
        let axis = self.geometry.axis;
        let shape = self.geometry.extent.axis().map(|_| Shape {
            major_px: 2.0 * f64::from(half.0.max(half.1)),
            minor_px: 2.0 * f64::from(half.0.min(half.1)),
            axis: to_anticlockwise(axis, core::f64::consts::PI),
        });
        let bow = self.geometry.extent.axis().and_then(|_| self.heading.is_bow_at_axis_end());
        let end = |is_at_end: bool| if is_at_end { axis } else { axis + core::f32::consts::PI };
        Localisation {
            captured: frame.capture.at,
            picture: frame.picture.size(),
            centre: self.hull_centre(),
            bounds,
            shape,
            heading: bow.map(|is_at_end| to_anticlockwise(end(is_at_end), core::f64::consts::TAU)),
            confidence,
        }
    }

    /// The hull's centre; the centre of the reported box where there is no reference silhouette.
    ///
    /// While the bow is unknown, the centre is taken halfway between the ends of the colour. That is wrong where bow or
    /// stern have another paint, or where the wake has the target's colour. Once the bow is known, the centre follows
    /// from the operator's box, which contains the whole hull ([`ReferenceSilhouette::box_astern`]).
    fn hull_centre(&self) -> PixelPoint {
        let (u, v) = (f64::from(self.geometry.centre.0), f64::from(self.geometry.centre.1));
        let Some(reference) = &self.reference else {
            let [left, top, right, bottom] = self.reported_edges.unwrap_or_default().map(f64::from);
            return PixelPoint { u: u + 0.5 * (left + right), v: v + 0.5 * (top + bottom) };
        };
        let half = self.geometry.half_axes();
        let certainty = self.heading.signed_certainty() as f32;
        let along =
            certainty * reference.box_astern - (1.0 - certainty.abs()) * reference.box_from_midpoint.0;
        let (along, across) = (
            along * 2.0 * half.0 / reference.length,
            -reference.box_from_midpoint.1 * 2.0 * half.1 / reference.breadth,
        );
        let (c, s) = (libm::cosf(self.geometry.axis), libm::sinf(self.geometry.axis));
        PixelPoint { u: u + f64::from(along * c - across * s), v: v + f64::from(along * s + across * c) }
    }
}

/// Converts an angle clockwise from image right to one anticlockwise, from 0 (inclusive) to `period` (exclusive).
fn to_anticlockwise(clockwise: f32, period: f64) -> Angle {
    let turned = -f64::from(clockwise);
    let wrapped = turned - period * (turned / period).floor();
    // Rounding can give the period itself.
    Angle::from_radians(if wrapped < period { wrapped } else { 0.0 })
}
