//! Size, rotation, centre and heading of a target that was found in the frame.

use barrelman_vocab::{Picture, VideoFrame};

use super::config::FusedConfig;
use super::observation::Observation;
use super::shape_following::{FollowingTimes, axis_difference, follow_shape, is_within};
use super::target::Target;
use super::workspace::Workspace;
use crate::correlation::parabola_vertex;
use crate::crop::ColourContrast;
use crate::features::PatchPose;
use crate::heading::CameraMotionSource;
use crate::silhouette::Silhouette;

/// Standard deviation of a measured position, in sizes of the target.
const POSITION_STD_DEV_SIZES: f64 = 0.05;
/// Time constants with which axis, centre and size follow the silhouette's, seconds.
const TIMES: FollowingTimes = FollowingTimes { axis_s: 0.15, centre_s: 0.3, size_s: 1.0 };
/// With less of its usual contrast a target with a silhouette does not grow by the filter: the box contains background already, and the filter
/// has learned the target together with another thing that goes away from it.
const MIN_GROWING_CONTRAST: f32 = 0.6;
/// The silhouette is measured in the target's ellipse enlarged by this factor.
pub(super) const SILHOUETTE_REACH: f32 = 1.35;
/// A silhouette that fills less of the ellipse of its axes consists of several things: the target and others of its colour.
const MIN_SILHOUETTE_FILL: f32 = 0.7;
/// A silhouette whose length or breadth differs by a larger factor includes something else.
const MAX_MISFIT: f32 = 1.5;

/// Interval, in frames with the target found, at which the colour blob is measured, ...
const BLOB_INTERVAL: u32 = 8;
/// ... in this many steps, in ellipses with half axes of at least this many pixels, ...
const BLOB_STEPS: usize = 5;
const MIN_BLOB_HALF_PX: f32 = 6.0;
/// ... from the pixels whose target probability is nearer to this one than to that around the box.
const BLOB_PROBABILITY: f32 = 0.95;
/// Minimum contrast of a blob.
const MIN_BLOB_CONTRAST: f32 = 0.4;
/// A box with less contrast than this share of the blob's has slipped off, ...
const SLIPPED_SHARE: f32 = 0.6;
/// ... and is corrected after this many consecutive checks.
const SLIPPED_CHECKS: u32 = 4;

/// Probabilities of the refined box from which on its edges are followed, and followed fully.
const EDGE_PROBABILITIES: (f32, f32) = (0.1, 0.5);
/// Largest share of the way that an edge moves in a frame, and the expected error, in sides, at which it moves half as
/// far.
const MAX_EDGE_RATE: f32 = 0.5;
const EDGE_DRIFT: f32 = 0.02;
/// Largest step of an edge in a frame, sides.
const MAX_EDGE_STEP: f32 = 0.2;
/// Largest distance of the box from the filter's response, sizes.
const MAX_OFFSET_SIZES: f32 = 1.0;
/// Share of a change of the box that the filter's size follows in a frame.
const SIZE_SHARE: f32 = 0.06;

impl Workspace {
    /// Measures the target at an accepted observation, `seconds` after the last frame, and updates its state.
    pub(super) fn refine(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        observation: &Observation,
        frame: &VideoFrame,
        seconds: f64,
    ) {
        let before = target.geometry.centre;
        let pose = PatchPose { centre: observation.centre, ..observation.pose };
        let present = self.response_at(target, &pose);
        let gain = config.change_gain as f32;
        let scale_steps = self.best_step(target, present, gain, |steps| PatchPose {
            step: pose.step * libm::powf(config.scale_step as f32, steps),
            ..pose
        });
        let turn_step = config.turn_step_deg.to_radians() as f32;
        let turn_steps = self.best_step(target, present, gain, |steps| PatchPose {
            angle: pose.angle + steps * turn_step,
            ..pose
        });
        target.geometry.centre = target.geometry.box_centre_at(observation.centre);
        // Size and rotation of a target that is partly outside the picture cannot be measured.
        if !target.geometry.touches_border() {
            let may_grow = target.reference.is_none()
                || observation.relative_contrast(target).is_none_or(|share| share >= MIN_GROWING_CONTRAST);
            if may_grow || scale_steps < 0.0 {
                target.geometry.rescale(libm::powf(config.scale_step as f32, scale_steps));
            }
            target.geometry.turn(turn_steps * turn_step);
            let seconds = seconds as f32;
            // The silhouette of all colours is the more exact one, where the target is not too small for it.
            match self.find_blob(target, seconds) {
                Some(blob) if !blob.fits => Self::follow_blob(target, &blob, seconds),
                blob => {
                    let is_followed = self.follow_silhouette(target, observation, seconds);
                    if let Some(blob) = blob.filter(|_| !is_followed) {
                        Self::follow_blob(target, &blob, seconds);
                    }
                }
            }
            self.correct_slipped_box(config, target, &frame.picture);
            self.correct_contradicted_box(config, target, &frame.picture, seconds);
        }
        if target.reference.is_none() {
            self.follow_refined_box(target, observation.centre);
        }

        let size = f64::from(target.geometry.size_px());
        target.motion.correct(target.geometry.centre, POSITION_STD_DEV_SIZES * size);
        update_heading(target, before, frame.capture.at.as_secs_f64(), seconds);
        if !target.motion.has_precise_prior {
            self.set_background_reference(target, &frame.picture);
        }
    }

    /// The filter's response without shift at a pose.
    fn response_at(&mut self, target: &Target, pose: &PatchPose) -> f32 {
        self.features.response_at(
            &mut self.crop,
            pose,
            &target.appearance.filter,
            target.appearance.mask_half_cells,
            target.geometry.picture_size(),
        )
    }

    /// Number of steps, -2 to 2, at which the response is highest, interpolated by a parabola. `present` is the
    /// response without a step; the others are multiplied by `gain`.
    fn best_step(
        &mut self,
        target: &Target,
        present: f32,
        gain: f32,
        pose_after: impl Fn(f32) -> PatchPose,
    ) -> f32 {
        let mut score = |steps: f32| gain * self.response_at(target, &pose_after(steps));
        let (below, above) = (score(-1.0), score(1.0));
        if below <= present && above <= present {
            return parabola_vertex(below, present, above);
        }
        // One step is better; two may be better still.
        let (side, near) = if above > below { (1.0, above) } else { (-1.0, below) };
        let far = score(2.0 * side);
        if far > near { 2.0 * side } else { side * (1.0 + parabola_vertex(present, near, far)) }
    }

    /// Moves the edges of a target without a silhouette towards those of the refinement. An edge moves the faster the
    /// smaller the error that is expected of it. `place` is that of the filter's response, pixels.
    fn follow_refined_box(&self, target: &mut Target, place: (f32, f32)) {
        let certainty = ((self.refined.probability - EDGE_PROBABILITIES.0)
            / (EDGE_PROBABILITIES.1 - EDGE_PROBABILITIES.0))
            .clamp(0.0, 1.0);
        let (width, height) = self.window.box_size;
        let mut edges = self.window.box_edges();
        for (index, edge) in edges.iter_mut().enumerate() {
            let error = self.refined.errors[index];
            let rate = certainty * MAX_EDGE_RATE / (1.0 + (error / EDGE_DRIFT) * (error / EDGE_DRIFT));
            let limit = MAX_EDGE_STEP * if index % 2 == 0 { width } else { height };
            *edge += (rate * (self.refined.edges[index] - *edge)).clamp(-limit, limit);
        }
        let [left, top, right, bottom] = edges;
        let (u, v) = self.window.centre;
        let geometry = &mut target.geometry;
        let size = geometry.size_px();
        let moved = |offset: f32, from: f32, to: f32, old: f32| {
            (offset + (0.5 * (from + to) - old) / size).clamp(-MAX_OFFSET_SIZES, MAX_OFFSET_SIZES)
        };
        geometry.offset =
            (moved(geometry.offset.0, left, right, u), moved(geometry.offset.1, top, bottom, v));
        geometry.reshape_box((right - left) / width, (bottom - top) / height, SIZE_SHARE);
        geometry.centre = geometry.box_centre_at(place);
    }

    /// Corrects the drift of axis, centre, length and breadth by the silhouette. Whether it could.
    fn follow_silhouette(&mut self, target: &mut Target, observation: &Observation, seconds: f32) -> bool {
        let Some(reference) = target.reference else { return false };
        let geometry = &mut target.geometry;
        let (along, across) = geometry.half_axes();
        let half = (SILHOUETTE_REACH * along, SILHOUETTE_REACH * across);
        let Some(seen) =
            Silhouette::measure(&self.crop, geometry.centre, half, geometry.axis, observation.contrast)
        else {
            return false;
        };
        if seen.fill() < MIN_SILHOUETTE_FILL {
            return false;
        }
        let (length, breadth) = reference.size_of(&seen);
        let fits = |measured: f32, known: f32| is_within(measured / known, MAX_MISFIT);
        if !(fits(length, 2.0 * along) && fits(breadth, 2.0 * across)) || geometry.touches_border() {
            return false;
        }
        follow_shape(geometry, &reference, &seen, TIMES, seconds);
        true
    }

    /// Moves a box with a silhouette back that slipped off its target while the filter adapted.
    ///
    /// Filter and silhouette are evaluated at the box. Once the box covers a part of the target, or its wake, both
    /// confirm that. Therefore the blob of the target's colour is followed at intervals from the box to its ends. If the
    /// box has much less contrast than the blob in several consecutive checks, the blob is the target: the box is moved
    /// onto it and the filter is retrained. Another object of the same colour beside the target has no effect, since
    /// the target's own box keeps its contrast.
    fn correct_slipped_box(&mut self, config: &FusedConfig, target: &mut Target, picture: &Picture) {
        let Some(reference) = target.reference else { return };
        target.drift.frames = target.drift.frames.wrapping_add(1);
        if !target.drift.frames.is_multiple_of(BLOB_INTERVAL) {
            return;
        }
        let geometry = &target.geometry;
        let contrast = self.crop.contrast(geometry.centre, geometry.half_axes(), geometry.axis);
        let has_slipped =
            |(_, blob_contrast): &(Silhouette, f32)| contrast.difference() < SLIPPED_SHARE * blob_contrast;
        let Some((seen, _)) = self.find_colour_blob(target, contrast.ring).filter(has_slipped) else {
            target.drift.misfits = 0;
            return;
        };
        target.drift.misfits += 1;
        if target.drift.misfits < SLIPPED_CHECKS {
            return;
        }
        target.drift.misfits = 0;
        let geometry = &mut target.geometry;
        geometry.axis += axis_difference(seen.axis, geometry.axis);
        geometry.centre = seen.centroid;
        let (longer, wider) = reference.stretch_of(&seen);
        geometry.stretch_to(reference.length * longer, reference.breadth * wider, 1.0);
        self.retrain_at_box(config, target, picture);
    }

    /// The blob of the target's colour that starts in the target's box, and its contrast. `ring` is the target
    /// probability around the box. `None` where the blob has too little contrast.
    fn find_colour_blob(&self, target: &Target, ring: f32) -> Option<(Silhouette, f32)> {
        let (along, across) = target.geometry.half_axes();
        let at_least = |half: f32| half.max(MIN_BLOB_HALF_PX);
        let mut centre = target.geometry.centre;
        let mut half = (at_least(2.0 * along), at_least(2.0 * along.max(across)));
        let mut angle = target.geometry.axis;
        let contrast = ColourContrast { inside: BLOB_PROBABILITY, ring };
        let mut found: Option<Silhouette> = None;
        for _ in 0..BLOB_STEPS {
            let seen = Silhouette::measure(&self.crop, centre, half, angle, contrast)?;
            centre = seen.centroid;
            half = (
                at_least(0.5 * SILHOUETTE_REACH * seen.major),
                at_least(0.5 * SILHOUETTE_REACH * seen.minor),
            );
            angle = seen.axis;
            found = Some(seen);
        }
        let seen = found?;
        let own = (0.5 * seen.major, 0.5 * seen.minor);
        let contrast = self.crop.contrast(seen.centroid, own, seen.axis).difference();
        (contrast >= MIN_BLOB_CONTRAST).then_some((seen, contrast))
    }
}

/// Adds the target's motion over the water since its centre was at `before` to the heading's path.
fn update_heading(target: &mut Target, before: (f32, f32), at_s: f64, seconds: f64) {
    if !target.motion.is_camera_shift_known {
        target.heading.clear_path();
        return;
    }
    let (geometry, shift) = (&target.geometry, target.motion.camera_shift);
    let (du, dv) = (geometry.centre.0 - before.0 - shift.0, geometry.centre.1 - before.1 - shift.1);
    let half = geometry.half_axes();
    let length = 2.0 * f64::from(half.0.max(half.1));
    let moved = (f64::from(du), f64::from(dv));
    let source = if target.motion.is_camera_motion_told {
        CameraMotionSource::Told
    } else {
        CameraMotionSource::Measured
    };
    target.heading.add_motion(at_s, seconds, moved, f64::from(geometry.axis), length, source);
}
