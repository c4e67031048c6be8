//! The stage that evaluates filter and colour in a search window.
//!
//! Input: the target's model, a picture and the pose of a search window. Output: an [`Observation`]. State:
//! crop, features and response of the last search window, which later stages use.

use barrelman_vocab::{Picture, PixelBox};

use super::config::FusedConfig;
use super::observation::Observation;
use super::prediction::Prediction;
use super::target::Target;
use crate::correlation::FixedFilter;
use crate::crop::Crop;
use crate::explanation::{Explanation, GreyMap};
use crate::features::{FeatureExtractor, PatchPose};
use crate::fourier::{AREA, Map, SIDE, Spectrum};
use crate::gradients::CELL;
use crate::peak::{Peak, parabola_vertex};
use crate::vector::Rotation;

/// Settings of the evaluation of search windows. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct ObserverSettings {
    /// Side of the crop, in sides of the search window. The crop also contains the patch that is learned
    /// from.
    crop_margin: f32,
    /// Minimum height of a second peak that is observed, relative to the first.
    min_second_height: f32,
    /// Maximum distance of a box from the middle of the crop, in sides of the search window. The crop is
    /// extracted again for a box farther away.
    max_off_centre: f32,
    /// Maximum of two standard deviations of the prediction, in sides of the search window. With a less
    /// certain prediction, the neighbouring windows are evaluated as well.
    max_uncertainty_share: f32,
    /// Relative contrast that does not change the evidence.
    neutral_colour: f32,
    /// Relative height of the response that does not change the evidence.
    neutral_height: f32,
    /// Evidence per unit of relative height.
    height_evidence: f32,
}

impl Default for ObserverSettings {
    fn default() -> Self {
        Self {
            crop_margin: 1.15,
            min_second_height: 0.5,
            max_off_centre: 0.15,
            max_uncertainty_share: 0.4,
            neutral_colour: 0.6,
            neutral_height: 0.5,
            height_evidence: 8.0,
        }
    }
}

/// Growth and rotation of a target since the last frame, by the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PoseChange {
    /// Factor on the size.
    pub(super) scale_factor: f32,
    /// Angle, radians clockwise.
    pub(super) turn: f32,
}

/// Evaluates search windows; keeps its buffers.
#[derive(Debug)]
pub(super) struct Observer {
    config: FusedConfig,
    settings: ObserverSettings,
    pub(super) crop: Crop,
    pub(super) features: FeatureExtractor,
    response_spectrum: Spectrum,
    response: Box<Map>,
    /// Response of a filter that does not adapt.
    fixed_response: Box<Map>,
    /// Pose of the last search window.
    pub(super) pose: PatchPose,
    /// Centre of the crop, pixels.
    crop_centre: (f32, f32),
}

impl Observer {
    pub(super) fn new(config: &FusedConfig) -> Self {
        Self {
            config: *config,
            settings: ObserverSettings::default(),
            crop: Crop::default(),
            features: FeatureExtractor::new(config.brightness_gain as f32, config.colour_gain as f32),
            response_spectrum: Spectrum::default(),
            response: Box::new([0.0; AREA]),
            fixed_response: Box::new([0.0; AREA]),
            pose: PatchPose { centre: (0.0, 0.0), step: 1.0, angle: 0.0 },
            crop_centre: (0.0, 0.0),
        }
    }

    /// Pose of the search window around the target's last position.
    pub(super) fn patch_pose(&self, target: &Target) -> PatchPose {
        target.geometry.patch_pose(self.config.padding)
    }

    /// Observes the window around the prediction, and its neighbours if the prediction is too uncertain.
    /// Returns the best observation, and keeps its crop.
    pub(super) fn observe_prediction(
        &mut self,
        target: &Target,
        prediction: &Prediction,
        picture: &Picture,
    ) -> Observation {
        let centre = target.geometry.clamped_to_picture(prediction.position);
        let pose = PatchPose { centre, ..self.patch_pose(target) };
        let side = pose.side_px();
        let mut best = self.observe(target, picture, pose);
        if 2.0 * prediction.std_dev > self.settings.max_uncertainty_share * side
            && best.evidence < self.config.learn as f32
        {
            for (right, down) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                let centre = (pose.centre.0 + 0.5 * right * side, pose.centre.1 + 0.5 * down * side);
                let observation = self.observe(target, picture, PatchPose { centre, ..pose });
                if observation.evidence > best.evidence {
                    best = observation;
                }
            }
            if best.pose != self.pose {
                // The following stages sample the crop of the best observation.
                best = self.observe(target, picture, best.pose);
            }
        }
        best
    }

    /// Observes a candidate in both directions of its axis, since a hull looks similar from either end.
    /// Returns the observation with more evidence, and whether that is the one in the other direction.
    pub(super) fn observe_either_direction(
        &mut self,
        target: &Target,
        picture: &Picture,
        observation: Observation,
    ) -> (Observation, bool) {
        let angle = observation.pose.angle + core::f32::consts::PI;
        let reversed = self.observe(target, picture, PatchPose { angle, ..observation.pose });
        if reversed.evidence > observation.evidence {
            return (reversed, true);
        }
        // The following stages sample the crop of the returned observation.
        (self.observe(target, picture, observation.pose), false)
    }

    /// Evaluates filter and colour in one search window.
    pub(super) fn observe(&mut self, target: &Target, picture: &Picture, pose: PatchPose) -> Observation {
        self.extract_crop(target, picture, &pose);
        self.extract_features(target, &pose);
        target.appearance.filter.correlate(&self.features.spectra, &mut self.response_spectrum);
        self.features.fourier.inverse(&self.response_spectrum, &mut self.response);
        self.pose = pose;
        self.observation_at(target, Peak::find(&self.response))
    }

    /// The observation at the second highest peak of the last search window. `None` if that peak is much
    /// lower.
    pub(super) fn observe_second_peak(&self, target: &Target, first: &Observation) -> Option<Observation> {
        let second = first.peak.find_second(&self.response)?;
        (second.height > self.settings.min_second_height * first.peak.height)
            .then(|| self.observation_at(target, second))
    }

    /// The observation at the highest peak of the last search window that `is_allowed` (shift right and down,
    /// cells). `highest` is the observation at the highest peak.
    pub(super) fn observe_other(
        &self,
        target: &Target,
        highest: &Observation,
        is_allowed: impl Fn(f32, f32) -> bool,
    ) -> Option<Observation> {
        let other = highest.peak.find_other(&self.response, is_allowed)?;
        Some(self.observation_at(target, other))
    }

    /// The response of a filter that does not adapt in the last search window.
    pub(super) fn respond(&mut self, filter: &FixedFilter) -> &Map {
        filter.correlate(&self.features.spectra, &mut self.response_spectrum);
        self.features.fourier.inverse(&self.response_spectrum, &mut self.fixed_response);
        &self.fixed_response
    }

    /// The observation at a peak of the last search window.
    pub(super) fn observation_at(&self, target: &Target, peak: Peak) -> Observation {
        let (pose, geometry) = (self.pose, &target.geometry);
        let centre = geometry.clamped_to_picture(pose.cell_to_picture(peak.right, peak.down));
        let contrast =
            self.crop.contrast(geometry.box_centre_at(centre), geometry.half_axes(), geometry.axis_in(&pose));
        let usual = &target.appearance.usual;
        let relative_contrast = usual.relative_contrast(contrast);
        let relative_height = usual.relative_height(peak.height);
        let evidence = self.evidence(peak.peak_to_sidelobe_ratio, relative_contrast, relative_height);
        Observation { pose, centre, peak, contrast, relative_height, relative_contrast, evidence }
    }

    /// Evidence for the target, in standard deviations of the response's sidelobes.
    fn evidence(&self, peak_to_sidelobe_ratio: f32, contrast: Option<f32>, height: f32) -> f32 {
        let settings = &self.settings;
        let colour = contrast.map_or(0.0, |share| share - settings.neutral_colour);
        let height = height.clamp(0.0, 1.0) - settings.neutral_height;
        peak_to_sidelobe_ratio
            + self.config.colour_evidence as f32 * colour
            + settings.height_evidence * height
    }

    /// Growth and rotation of the target since the last frame, by the responses at an observation.
    pub(super) fn measure_pose_change(&mut self, target: &Target, observation: &Observation) -> PoseChange {
        let config = self.config;
        let pose = PatchPose { centre: observation.centre, ..observation.pose };
        let present = self.response_at(target, &pose);
        let scale_step = config.scale_step as f32;
        let scale_steps = self.best_step(target, present, |steps| PatchPose {
            step: pose.step * libm::powf(scale_step, steps),
            ..pose
        });
        let turn_step = config.turn_step_deg.to_radians() as f32;
        let turn_steps = self
            .best_step(target, present, |steps| PatchPose { angle: pose.angle + steps * turn_step, ..pose });
        PoseChange { scale_factor: libm::powf(scale_step, scale_steps), turn: turn_steps * turn_step }
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

    /// Number of steps, -2 to 2, at which the response is highest, interpolated by a parabola. `present` is
    /// the response without a step; the others are multiplied by the user's `change_gain`.
    fn best_step(&mut self, target: &Target, present: f32, pose_after: impl Fn(f32) -> PatchPose) -> f32 {
        let gain = self.config.change_gain as f32;
        let mut score = |steps: f32| gain * self.response_at(target, &pose_after(steps));
        let (below, above) = (score(-1.0), score(1.0));
        if below <= present && above <= present {
            return parabola_vertex(below, present, above);
        }
        // The response is higher after one step. It may be still higher after two.
        let (side, near) = if above > below { (1.0, above) } else { (-1.0, below) };
        let far = score(2.0 * side);
        if far > near { 2.0 * side } else { side * (1.0 + parabola_vertex(present, near, far)) }
    }

    /// Extracts the crop of the patch around the target, and the patch's features.
    pub(super) fn extract_patch(&mut self, target: &Target, picture: &Picture) {
        let pose = self.patch_pose(target);
        self.extract_crop(target, picture, &pose);
        self.pose = pose;
        self.extract_features(target, &pose);
    }

    /// Computes the spectra of the patch at a pose in the last crop.
    pub(super) fn extract_features(&mut self, target: &Target, pose: &PatchPose) {
        self.features.extract(&mut self.crop, pose, target.geometry.picture_size());
    }

    /// Extracts the crop that contains a search window.
    pub(super) fn extract_crop(&mut self, target: &Target, picture: &Picture, pose: &PatchPose) {
        let Rotation { cos, sin } = Rotation::by(pose.angle);
        let widening = cos.abs() + sin.abs();
        let reach = 0.5 * pose.step * (SIDE * CELL + 2) as f32 * widening * self.settings.crop_margin;
        self.crop.extract(picture, &target.appearance.colours, pose.centre, reach, pose.step);
        self.crop_centre = pose.centre;
    }

    /// Extracts the crop again around an observation's box if the box lies far from the middle of the last
    /// crop. Returns the centre of the box, pixels.
    pub(super) fn centre_crop(
        &mut self,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
    ) -> (f32, f32) {
        let (u, v) = target.geometry.box_centre_at(observation.centre);
        let (du, dv) = (u - self.crop_centre.0, v - self.crop_centre.1);
        if du.abs().max(dv.abs()) > self.settings.max_off_centre * observation.pose.side_px() {
            self.extract_crop(target, picture, &PatchPose { centre: (u, v), ..observation.pose });
        }
        (u, v)
    }

    /// Writes the last search window; `out` is empty.
    pub(super) fn explain(&self, out: &mut Explanation) {
        let side = f64::from(self.pose.side_px());
        let corner = |middle: f32| f64::from(middle) - 0.5 * side;
        let (u, v) = self.pose.centre;
        let window = PixelBox { u: corner(u), v: corner(v), w: side, h: side };
        out.search_window = Some(window);
        out.response.bounds = window;
        self.crop.write_probability_map(&mut out.back_projection);
        write_response(&self.response, self.pose.angle, &mut out.response);
    }
}

/// Writes the response of a search window that is rotated by `angle`, as an upright map with values 0 to 255.
fn write_response(response: &Map, angle: f32, out: &mut GreyMap) {
    (out.width, out.height) = (SIDE, SIDE);
    let highest = response.iter().fold(f32::MIN_POSITIVE, |highest, &value| highest.max(value));
    let turn = Rotation::by(angle);
    let middle = (SIDE / 2) as f32;
    out.samples.extend((0..AREA).map(|index| {
        let (right, down) = ((index % SIDE) as f32 + 0.5 - middle, (index / SIDE) as f32 + 0.5 - middle);
        let (column, row) = turn.undo((right, down));
        let wrapped = |shift: f32| (shift.floor() as i32).rem_euclid(SIDE as i32) as usize;
        (255.0 * response[wrapped(row) * SIDE + wrapped(column)] / highest).clamp(0.0, 255.0) as u8
    }));
}
