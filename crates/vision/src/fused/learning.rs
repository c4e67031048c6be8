//! Learning: the whole appearance from the selection, a small share from each reliable frame.

use barrelman_vocab::{Picture, PixelBox, VideoFrame};

use super::appearance::Appearance;
use super::box_probability::BoxProbability;
use super::config::FusedConfig;
use super::contradiction::Contradiction;
use super::extent::Extent;
use super::filter_views::FilterViews;
use super::geometry::TargetGeometry;
use super::known_scene::KnownScene;
use super::loss::{Identity, LossState};
use super::observation::Observation;
use super::phase::Phase;
use super::prediction::TargetMotion;
use super::reference_silhouette::ReferenceSilhouette;
use super::surroundings::Surroundings;
use super::target::{DriftCheck, Target};
use super::workspace::Workspace;
use crate::colour_model::{ColourModel, TargetEllipse, count_colours};
use crate::correlation::desired_response_spectrum;
use crate::features::{CHANNELS, PatchPose};
use crate::fourier::{AREA, Map, SIDE};
use crate::gradients::CELL;
use crate::heading::HeadingEstimator;
use crate::refinement::WindowMemory;
use crate::silhouette::Silhouette;

/// ADMM steps of the filter at the selection, and per learned frame, which continues from the last solution.
const INITIAL_ADMM_STEPS: usize = 6;
const ADMM_STEPS: usize = 2;
/// Interval, in learned frames, at which the colours are counted.
const COLOUR_INTERVAL: u32 = 4;
/// Minimum relative contrast at which the colours adapt.
const MIN_ADAPTED_CONTRAST: f32 = 0.6;
/// Rate of the usual values: about twenty frames.
const USUAL_RATE: f32 = 0.05;
/// Rate of the usual similarities, which are measured in every fourth frame only.
const SIMILARITY_RATE: f32 = 0.15;
/// A silhouette is trusted to measure size and axis later if at the selection it had at least this contrast, ...
const MIN_TRUSTED_CONTRAST: f32 = 0.5;
/// ... its upright box matched the operator's within this factor, ...
const MAX_TRUSTED_STRETCH: f32 = 1.25;
/// ... and it filled at least this share of the ellipse.
const MIN_TRUSTED_FILL: f32 = 0.5;
/// Ellipse around the selection's box, in half sides of the box: a corner is 1.41 half sides from the centre.
pub(super) const BOX_ELLIPSE: f32 = 1.42;
/// Minimum target probability of a pixel that counts as coloured, 0 to 255.
const MIN_COLOURED_PROBABILITY: u8 = 128;

/// A dragged box is replaced by the refined one if that has at least this probability, these sides (pixels), and less
/// than this IoU with the dragged one.
const MIN_TIGHTENING_PROBABILITY: f32 = 0.5;
pub(super) const MIN_TIGHTENED_PX: (f64, f64) = (6.0, 4.0);
const MAX_KEPT_IOU: f64 = 0.7;
/// Increase of the filter's learning rate with the box's distance from the filter's place, per size, and the largest
/// rate.
const OFFSET_BOOST: f32 = 3.0;
const MAX_LEARNING_RATE: f32 = 0.3;

/// How distinct the colours of a selection are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SelectionColours {
    /// Share of the selection's pixels whose colour is more likely the target's than the surroundings', 0 to 1.
    pub(super) coloured_share: f64,
    /// Mean target probability in the ring around the selection, 0 to 1.
    pub(super) surroundings_probability: f64,
}

impl Workspace {
    /// Creates the target from a box that the operator dragged, and the box that is used: the refined one where the
    /// dragged one is clearly too large or off, or where the silhouette agrees with the refined one alone.
    pub(super) fn learn_selection(
        &mut self,
        config: &FusedConfig,
        frame: &VideoFrame,
        dragged: PixelBox,
    ) -> (Target, SelectionColours, PixelBox) {
        let (target, colours) = self.learn_box(config, frame, dragged);
        let refined = self.refined.bounds().clipped(frame.picture.size());
        // The network tells whether the paint is the target or a part of it.
        let is_better = |painted: &PixelBox| refined.iou(*painted) > refined.iou(dragged);
        if let Some(painted) = self.painted_box(dragged).filter(is_better) {
            let (tightened, its_colours) = self.learn_box(config, frame, painted);
            return (tightened, its_colours, painted);
        }
        let is_plausible = self.refined.probability > MIN_TIGHTENING_PROBABILITY
            && refined.w >= MIN_TIGHTENED_PX.0
            && refined.h >= MIN_TIGHTENED_PX.1;
        let is_off = refined.iou(dragged) < MAX_KEPT_IOU;
        if !is_plausible || !is_off && target.reference.is_some() {
            return (target, colours, dragged);
        }
        let (tightened, its_colours) = self.learn_box(config, frame, refined);
        if is_off || tightened.reference.is_some() {
            return (tightened, its_colours, refined);
        }
        // Window and references of the workspace have to be those of the box that is used.
        let (target, colours) = self.learn_box(config, frame, dragged);
        (target, colours, dragged)
    }

    /// Creates the target from a box on a frame, and refines the box.
    fn learn_box(
        &mut self,
        config: &FusedConfig,
        frame: &VideoFrame,
        used: PixelBox,
    ) -> (Target, SelectionColours) {
        let picture = &*frame.picture;
        let mut target = new_target(frame, used);
        let box_size = (used.w as f32, used.h as f32);
        let pose = target.patch_pose(config);
        self.extract_crop(&target, picture, &pose);
        let colours = self.measure_selection_colours(&mut target, box_size);
        // The extent may have changed the window.
        let pose = target.patch_pose(config);
        let cell = pose.step * CELL as f32;
        let std_dev = config.response_deviation as f32 * target.geometry.initial_size_px / cell;
        let half =
            (0.5 * config.mask as f32 * box_size.0 / cell, 0.5 * config.mask as f32 * box_size.1 / cell);
        let appearance = &mut target.appearance;
        appearance.desired_response = desired_response_spectrum(&mut self.features.fourier, std_dev);
        appearance.mask = mask(half);
        appearance.mask_half_cells = (half.0.ceil() as usize, half.1.ceil() as usize);
        self.retrain(&mut target, picture, pose);
        target.views.restart(&target.appearance.filter, target.appearance.usual.peak_height);
        self.set_background_reference(&target, picture);
        self.window.measurements.fill(0.0);
        self.references.clear();
        self.refine_box(&target, target.geometry.centre, target.geometry.upright_box());
        self.window.remember_selection(&mut target.memory);
        self.references.update(&self.crop, target.geometry.centre, frame.capture.at.as_secs_f64());
        (target, colours)
    }

    /// Retrains the filter and the layout from a single frame, around a box that was moved.
    pub(super) fn retrain_at_box(&mut self, config: &FusedConfig, target: &mut Target, picture: &Picture) {
        let pose = target.patch_pose(config);
        self.retrain(target, picture, pose);
    }

    /// Retrains the filter and the layout from a single frame.
    pub(super) fn retrain(&mut self, target: &mut Target, picture: &Picture, pose: PatchPose) {
        self.extract_crop(target, picture, &pose);
        self.pose = pose;
        let (geometry, appearance) = (&target.geometry, &mut target.appearance);
        self.features.extract(&mut self.crop, &pose, geometry.picture_size());
        appearance.filter.update_model(&self.features.spectra, 1.0);
        for _ in 0..INITIAL_ADMM_STEPS {
            appearance.filter.solve_step(
                &mut self.features.fourier,
                &appearance.desired_response,
                &appearance.mask,
            );
        }
        appearance.layout.count(picture, geometry.centre, geometry.half_axes(), geometry.axis);
    }

    /// Makes this frame the reference of background registration.
    pub(super) fn set_background_reference(&mut self, target: &Target, picture: &Picture) {
        self.background.set_reference(
            picture.y(),
            &mut self.features.fourier,
            target.geometry.centre,
            target.geometry.blanked_side_px(),
        );
    }

    /// Measures how distinct the selection's colours are, and takes extent and reference silhouette from them.
    fn measure_selection_colours(&mut self, target: &mut Target, box_size: (f32, f32)) -> SelectionColours {
        let half = (0.5 * box_size.0, 0.5 * box_size.1);
        let centre = target.geometry.centre;
        let contrast = self.crop.contrast(centre, half, 0.0);
        let ellipse = (BOX_ELLIPSE * half.0, BOX_ELLIPSE * half.1);
        let (mut coloured, mut count) = (0_u32, 0_u32);
        self.crop.for_each_probability(centre, ellipse, 0.0, |du, dv, probability| {
            if du.abs() <= half.0 && dv.abs() <= half.1 {
                coloured += u32::from(probability >= MIN_COLOURED_PROBABILITY);
                count += 1;
            }
        });
        let silhouette = Silhouette::measure(&self.crop, centre, ellipse, 0.0, contrast).filter(|seen| {
            let own = (0.5 * seen.major, 0.5 * seen.minor);
            self.crop.contrast(seen.centroid, own, seen.axis).difference() >= MIN_TRUSTED_CONTRAST
        });
        let extent = Extent::from_selection(box_size, silhouette.as_ref());
        target.geometry.extent = extent;
        target.loss.reliable_size = (1.0, extent);
        target.geometry.axis = extent.axis().unwrap_or(0.0);
        target.reference =
            silhouette.and_then(|seen| reference_silhouette(&seen, &extent, centre, target.geometry.axis));
        self.learn_paint(target, box_size);
        if target.reference.is_none() {
            // Without a silhouette, the refinement follows an upright box.
            let extent = Extent::Box { width: box_size.0, height: box_size.1 };
            (target.geometry.extent, target.geometry.axis) = (extent, 0.0);
            target.loss.reliable_size = (1.0, extent);
        }
        let contrast = self.crop.contrast(centre, target.geometry.half_axes(), target.geometry.axis);
        target.appearance.usual.contrast = contrast.difference();
        SelectionColours {
            coloured_share: if count == 0 { 0.0 } else { f64::from(coloured) / f64::from(count) },
            surroundings_probability: f64::from(contrast.ring),
        }
    }

    /// Adapts to a frame in which the target is well visible.
    pub(super) fn learn(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        observation: &Observation,
    ) {
        let pose = target.patch_pose(config);
        self.features.extract(&mut self.crop, &pose, target.geometry.picture_size());
        self.window.remember_usual(&mut target.memory);
        self.keep_view(target);
        // The filter learns the box's centre as its own place. Where the two differ, it learns faster.
        let (right, down) = target.geometry.offset;
        let boost = 1.0 + OFFSET_BOOST * libm::hypotf(right, down);
        let rate = (config.learning_rate as f32 * boost).min(MAX_LEARNING_RATE);
        target.geometry.offset = (right * (1.0 - rate), down * (1.0 - rate));
        let appearance = &mut target.appearance;
        appearance.filter.update_model(&self.features.spectra, rate);
        for _ in 0..ADMM_STEPS {
            appearance.filter.solve_step(
                &mut self.features.fourier,
                &appearance.desired_response,
                &appearance.mask,
            );
        }
        let height = observation.peak.height.clamp(0.0, 1.0);
        appearance.usual.peak_height += USUAL_RATE * (height - appearance.usual.peak_height);
        let has_its_colour =
            observation.relative_contrast(target).is_none_or(|share| share >= MIN_ADAPTED_CONTRAST);
        let appearance = &mut target.appearance;
        if has_its_colour {
            appearance.usual.contrast +=
                USUAL_RATE * (observation.contrast.difference() - appearance.usual.contrast);
        }
        target.loss.reliable_size = (target.geometry.scale, target.geometry.extent);
        appearance.frames_learned = appearance.frames_learned.wrapping_add(1);
        if has_its_colour
            && config.colour_rate > 0.0
            && appearance.frames_learned.is_multiple_of(COLOUR_INTERVAL)
        {
            self.learn_colours(config, target, picture);
        }
    }

    /// Adapts the colour model and the layout to a frame.
    fn learn_colours(&mut self, config: &FusedConfig, target: &mut Target, picture: &Picture) {
        let (geometry, appearance) = (&target.geometry, &mut target.appearance);
        let [inside, ring] = &mut self.histograms;
        count_colours(picture, geometry.centre, &geometry.ellipse(), inside, ring);
        let usual = &mut appearance.usual;
        let similarity = inside.similarity(&appearance.colours.target);
        usual.similarity += SIMILARITY_RATE * (similarity - usual.similarity);
        appearance.colours.adapt(inside, ring, config.colour_rate as f32);
        self.layout.count(picture, geometry.centre, geometry.half_axes(), geometry.axis);
        let similarity = self.layout.similarity(&appearance.layout);
        usual.layout_similarity += SIMILARITY_RATE * (similarity - usual.layout_similarity);
        appearance.layout.blend(&self.layout, config.colour_rate as f32);
    }
}

/// A target with the colours of the selection; filter, extent and reference silhouette are not known yet.
fn new_target(frame: &VideoFrame, used: PixelBox) -> Target {
    let picture = &*frame.picture;
    let now = frame.capture.at;
    let middle = used.centre();
    let centre = (middle.u as f32, middle.v as f32);
    let box_size = (used.w as f32, used.h as f32);
    let mut colours = ColourModel::default();
    let ellipse = TargetEllipse::inscribed_in(box_size);
    count_colours(picture, centre, &ellipse, &mut colours.target, &mut colours.surroundings);
    colours.remember_selection();
    colours.update_table();
    let geometry = TargetGeometry::new(centre, box_size, picture.size());
    Target {
        phase: Phase::Tracking,
        motion: TargetMotion::new(now, (middle.u, middle.v), f64::from(geometry.initial_size_px)),
        appearance: Appearance::new(colours),
        reference: None,
        heading: HeadingEstimator::default(),
        drift: DriftCheck::default(),
        contradiction: Contradiction::default(),
        surroundings: Surroundings::default(),
        views: FilterViews::new(CHANNELS),
        scene: KnownScene::default(),
        blob: None,
        paint: None,
        identity: Identity::Sure,
        loss: LossState::new(now, centre, geometry.extent),
        memory: WindowMemory::default(),
        reported_edges: None,
        confidence: 1.0,
        probability: BoxProbability::of_selection(now),
        geometry,
    }
}

/// The reference silhouette of a selection with its box around `centre`, if the silhouette can be trusted.
pub(super) fn reference_silhouette(
    seen: &Silhouette,
    extent: &Extent,
    centre: (f32, f32),
    axis: f32,
) -> Option<ReferenceSilhouette> {
    let Extent::Hull { length, breadth, stretch, .. } = *extent else { return None };
    let matches_box = |stretch: f32| (1.0 / MAX_TRUSTED_STRETCH..=MAX_TRUSTED_STRETCH).contains(&stretch);
    let fill = seen.area / (0.25 * core::f32::consts::PI * length * breadth);
    let is_trusted = matches_box(stretch.0) && matches_box(stretch.1) && fill >= MIN_TRUSTED_FILL;
    is_trusted.then(|| ReferenceSilhouette::of_hull(seen, (length, breadth), centre, axis))
}

/// A mask of ones within half sides given in cells around the centre, with an edge one cell wide.
fn mask(half: (f32, f32)) -> Box<Map> {
    let mut map: Box<Map> = Box::new([0.0; AREA]);
    for (index, value) in map.iter_mut().enumerate() {
        let from_middle = |k: usize| ((k as f32) + 0.5 - (SIDE / 2) as f32).abs();
        let within = |half: f32, distance: f32| (half + 0.5 - distance).clamp(0.0, 1.0);
        *value = within(half.0, from_middle(index % SIDE)) * within(half.1, from_middle(index / SIDE));
    }
    map
}
