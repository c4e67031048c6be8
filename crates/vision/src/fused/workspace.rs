//! The working memory of the fused tracker, and one observation with it.

use std::sync::Arc;

use barrelman_vocab::{Picture, PixelBox};

use super::config::FusedConfig;
use super::observation::Observation;
use super::phase::Phase;
use super::target::Target;
use crate::background::BackgroundMotion;
use crate::colour_model::ColourHistogram;
use crate::components::ComponentFinder;
use crate::correlation::{FixedFilter, Peak};
use crate::crop::Crop;
use crate::explanation::{Explanation, GreyMap, TrackerState};
use crate::features::{FeatureExtractor, PatchPose};
use crate::fourier::{AREA, Map, SIDE, Spectrum};
use crate::gradients::CELL;
use crate::layout::ColourLayout;
use crate::redetection::Redetector;
use crate::refinement::{
    Measurements, MotionReferences, RefinedBox, RefinementNetwork, RefinementWeights, RefinementWindow,
    WindowContext,
};

/// The crop exceeds the search window by this factor: it also serves the patch that is learned from.
const CROP_MARGIN: f32 = 1.15;

/// Minimum height of a second peak that is looked at, as a share of the first.
const MIN_SECOND_HEIGHT: f32 = 0.5;
/// Distance of a box from the middle of the crop, in sides of the search window, from which on the crop is extracted
/// anew around the box.
const MAX_OFF_CENTRE: f32 = 0.15;

/// What evaluates pictures, with its buffers.
#[derive(Debug)]
pub(super) struct Workspace {
    pub(super) crop: Crop,
    pub(super) features: FeatureExtractor,
    response_spectrum: Spectrum,
    response: Box<Map>,
    /// Response of a filter that does not adapt.
    fixed_response: Box<Map>,
    pub(super) redetector: Redetector,
    pub(super) background: BackgroundMotion,
    /// Colours inside the target's ellipse and in the ring around it, in one frame.
    pub(super) histograms: [ColourHistogram; 2],
    /// Layout of the colours in one frame.
    pub(super) layout: ColourLayout,
    /// Earlier frames around the target.
    pub(super) references: MotionReferences,
    /// Window of the last refinement, and the answer.
    pub(super) window: RefinementWindow,
    pub(super) refined: RefinedBox,
    /// Window of the best of the observations that are compared.
    pub(super) best_window: RefinementWindow,
    network: RefinementNetwork,
    /// Things of the target's colour.
    pub(super) components: ComponentFinder,
    /// Pose of the last search window.
    pub(super) pose: PatchPose,
    /// Centre of the crop, pixels.
    crop_centre: (f32, f32),
}

impl Workspace {
    /// Buffers for a tracker with these settings.
    pub(super) fn new(config: &FusedConfig, weights: Arc<RefinementWeights>) -> Self {
        Self {
            crop: Crop::default(),
            features: FeatureExtractor::new(config.brightness_gain as f32, config.colour_gain as f32),
            response_spectrum: Spectrum::default(),
            response: Box::new([0.0; AREA]),
            fixed_response: Box::new([0.0; AREA]),
            redetector: Redetector::default(),
            background: BackgroundMotion::new(),
            histograms: [ColourHistogram::default(), ColourHistogram::default()],
            layout: ColourLayout::default(),
            references: MotionReferences::default(),
            window: RefinementWindow::default(),
            refined: RefinedBox::default(),
            best_window: RefinementWindow::default(),
            network: RefinementNetwork::new(weights),
            components: ComponentFinder::default(),
            pose: PatchPose { centre: (0.0, 0.0), step: 1.0, angle: 0.0 },
            crop_centre: (0.0, 0.0),
        }
    }

    /// Evaluates filter and colour in one search window.
    pub(super) fn observe(&mut self, target: &Target, picture: &Picture, pose: PatchPose) -> Observation {
        self.extract_crop(target, picture, &pose);
        let size = target.geometry.picture_size();
        self.features.extract(&mut self.crop, &pose, size);
        target.appearance.filter.correlate(&self.features.spectra, &mut self.response_spectrum);
        self.features.fourier.inverse(&self.response_spectrum, &mut self.response);
        self.pose = pose;
        self.observation_at(target, Peak::find(&self.response))
    }

    /// The observation at the second highest peak of the last search window; `None` where it is much lower.
    pub(super) fn observe_second_peak(&self, target: &Target, first: &Observation) -> Option<Observation> {
        let second = first.peak.find_second(&self.response)?;
        (second.height > MIN_SECOND_HEIGHT * first.peak.height).then(|| self.observation_at(target, second))
    }

    /// The observation at the highest response of the last search window, that of `highest`, at another place
    /// that is allowed: by its shift right and down, cells.
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
        let (pose, size) = (self.pose, target.geometry.picture_size());
        let (u, v) = pose.to_picture(peak.right * CELL as f32, peak.down * CELL as f32);
        let centre = (u.clamp(0.0, size.0), v.clamp(0.0, size.1));
        let geometry = &target.geometry;
        let contrast =
            self.crop.contrast(geometry.box_centre_at(centre), geometry.half_axes(), geometry.axis_in(&pose));
        Observation { pose, centre, peak, contrast }
    }

    /// Extracts the crop that contains a search window.
    pub(super) fn extract_crop(&mut self, target: &Target, picture: &Picture, pose: &PatchPose) {
        let turn = libm::cosf(pose.angle).abs() + libm::sinf(pose.angle).abs();
        let reach = 0.5 * pose.step * (SIDE * CELL + 2) as f32 * turn * CROP_MARGIN;
        self.crop.extract(picture, &target.appearance.colours, pose.centre, reach, pose.step);
        self.crop_centre = pose.centre;
    }

    /// Extracts the crop anew around an observation's box if the box lies far from the middle of the last crop. The
    /// centre of the box, pixels.
    pub(super) fn centre_crop(
        &mut self,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
    ) -> (f32, f32) {
        let (u, v) = target.geometry.box_centre_at(observation.centre);
        let (du, dv) = (u - self.crop_centre.0, v - self.crop_centre.1);
        if du.abs().max(dv.abs()) > MAX_OFF_CENTRE * observation.pose.side_px() {
            self.extract_crop(target, picture, &PatchPose { centre: (u, v), ..observation.pose });
        }
        (u, v)
    }

    /// Makes an earlier observation the last one again: its refined box, the window that was kept, and its crop.
    pub(super) fn return_to(
        &mut self,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
        refined: RefinedBox,
    ) {
        self.window.copy_from(&self.best_window);
        self.refined = refined;
        self.centre_crop(target, picture, observation);
    }

    /// Evaluates the refinement network at an observation.
    pub(super) fn refine_observation(
        &mut self,
        config: &FusedConfig,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
    ) -> RefinedBox {
        let geometry = &target.geometry;
        let (u, v) = self.centre_crop(target, picture, observation);
        let size = geometry.size_px();
        self.window.set_measurements(&Measurements {
            peak_to_sidelobe_ratio: observation.peak.peak_to_sidelobe_ratio,
            relative_height: observation.relative_height(target),
            relative_contrast: observation.relative_contrast(target),
            usual_contrast: target.appearance.usual.contrast,
            inside: observation.contrast.inside,
            ring: observation.contrast.ring,
            scale: geometry.scale,
            distance_sizes: target.distance_from_prediction(observation) / size,
            relative_motion_sizes: self
                .references
                .relative_motion((u, v))
                .map(|(right, down)| libm::hypotf(right, down) / size),
            size_px: size,
            has_silhouette: target.reference.is_some(),
            evidence: observation.evidence(config, target),
        });
        self.refine_box(target, (u, v), geometry.upright_box())
    }

    /// Evaluates the refinement network at a box of this centre and size (width, height), pixels, in the last crop.
    pub(super) fn refine_box(
        &mut self,
        target: &Target,
        centre: (f32, f32),
        box_size: (f32, f32),
    ) -> RefinedBox {
        self.measure_window(target, centre, centre, box_size);
        self.refined = self.network.evaluate(&self.window);
        self.refined
    }

    /// Measures the window of the refinement network at a box of this centre and size, pixels, while the target's box has
    /// its centre at `tracked`.
    pub(super) fn measure_window(
        &mut self,
        target: &Target,
        tracked: (f32, f32),
        centre: (f32, f32),
        box_size: (f32, f32),
    ) {
        let context = WindowContext {
            tracked,
            picture: target.geometry.picture_size(),
            memory: &target.memory,
            references: &self.references,
        };
        self.window.measure(&mut self.crop, centre, box_size, context);
    }

    /// The weights of the refinement network.
    pub(super) fn weights(&self) -> Arc<RefinementWeights> {
        self.network.weights()
    }

    /// Writes what the last answer is based on; `out` is empty.
    pub(super) fn explain(&self, target: &Target, out: &mut Explanation) {
        let side = f64::from(self.pose.side_px());
        let corner = |middle: f32| f64::from(middle) - 0.5 * side;
        let (u, v) = self.pose.centre;
        let window = PixelBox { u: corner(u), v: corner(v), w: side, h: side };
        out.search_window = Some(window);
        out.response.bounds = window;
        self.crop.write_probability_map(&mut out.back_projection);
        write_response(&self.response, self.pose.angle, &mut out.response);
        out.state = Some(match target.phase {
            Phase::Tracking => TrackerState::Tracking,
            Phase::Coasting { .. } => TrackerState::Coasting,
            Phase::Lost { .. } => TrackerState::Lost,
            Phase::Confirming { .. } => TrackerState::Confirming,
        });
        out.confidence = target.confidence;
    }
}

/// Writes the response of a search window that is rotated by `angle`, as an upright map with values 0 to 255.
fn write_response(response: &Map, angle: f32, out: &mut GreyMap) {
    (out.width, out.height) = (SIDE, SIDE);
    let highest = response.iter().fold(f32::MIN_POSITIVE, |highest, &value| highest.max(value));
    let (cos, sin) = (libm::cosf(angle), libm::sinf(angle));
    let middle = (SIDE / 2) as f32;
    out.samples.extend((0..AREA).map(|index| {
        let (right, down) = ((index % SIDE) as f32 + 0.5 - middle, (index / SIDE) as f32 + 0.5 - middle);
        let (column, row) = (right * cos + down * sin, down * cos - right * sin);
        let wrapped = |shift: f32| (shift.floor() as i32).rem_euclid(SIDE as i32) as usize;
        (255.0 * response[wrapped(row) * SIDE + wrapped(column)] / highest).clamp(0.0, 255.0) as u8
    }));
}
