//! Search for a lost target in the whole picture, with a bounded number of observations per frame.

use barrelman_vocab::Picture;

use super::config::FusedConfig;
use super::evidence::{MIN_CONTRAST, rejected_confidence};
use super::loss::RecognitionScore;
use super::observation::Observation;
use super::target::Target;
use super::workspace::Workspace;
use crate::colour_model::count_colours;
use crate::crop::ColourContrast;
use crate::features::PatchPose;
use crate::redetection::{Candidate, MAX_CANDIDATES};
use crate::silhouette::Silhouette;

/// Candidates found by colour that are observed in one frame.
const COLOUR_CANDIDATES: usize = 2;
/// Distance of neighbouring windows of the systematic search, in sides of the window.
const SCAN_SPACING: f32 = 0.4;
/// Strides of the systematic search (primes), so that consecutive windows are not neighbours.
const SCAN_STRIDES: [u32; 4] = [7, 11, 13, 17];
/// Minimum relative height of the response and relative contrast of an observation that is compared with the target.
const MIN_RELATIVE_HEIGHT: f32 = 0.3;
const MIN_RELATIVE_CONTRAST: f32 = 0.2;
/// While a candidate is confirmed, its mean score may be lower by this than when it was found.
pub(super) const CONFIRMING_SLACK: f32 = 0.07;
/// Radius of the circle around a candidate in which its silhouette is measured, in half lengths of the target.
const SILHOUETTE_RADIUS: f32 = 1.3;
/// Sizes tried for a target without a reference silhouette, relative to its own.
const OTHER_SIZES: [f32; 2] = [0.75, 1.33];
/// Maximum factor by which a target may grow or shrink while it is lost.
const MAX_GROWTH: f32 = 1.7;
/// A silhouette with a larger ratio of minor to major axis gives no axis.
const MAX_ROUNDNESS: f32 = 0.8;
/// Upper bound of the target probability around a candidate, as a share of that inside.
const MAX_RING_SHARE: f32 = 0.5;

impl Workspace {
    /// The observation with the most evidence among those that are recognised as the lost target.
    pub(super) fn search_picture(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
    ) -> Option<Observation> {
        let pose = target.patch_pose(config);
        target.motion.decay(target.geometry.picture_size());
        target.confidence = 0.0;
        let centres = [target.motion.position_f32(), next_scan_centre(target, pose.side_px())];
        let mut search = PictureSearch { workspace: self, config, target, picture, best: None };
        for centre in centres {
            search.consider(PatchPose { centre, ..pose });
        }
        if search.target.appearance.usual.contrast > MIN_CONTRAST {
            search.search_by_colour(pose);
        }
        search.best.map(|(observation, _)| observation)
    }

    /// Candidates found by colour, sorted by the similarity of their layout to the target's, and their number.
    pub(super) fn rank_candidates(
        &mut self,
        target: &Target,
        picture: &Picture,
    ) -> ([Candidate; MAX_CANDIDATES], usize) {
        let upright_box = target.geometry.upright_box();
        let found = self.redetector.find_candidates(picture, &target.appearance.colours, upright_box);
        let mut candidates = [Candidate::default(); MAX_CANDIDATES];
        let count = found.len();
        candidates[..count].copy_from_slice(found);
        let half = target.geometry.half_axes();
        for candidate in &mut candidates[..count] {
            let half = (half.0 * candidate.scale, half.1 * candidate.scale);
            self.layout.count(picture, candidate.centre, half, target.geometry.axis);
            candidate.layout_similarity = self.layout.similarity(&target.appearance.layout);
        }
        candidates[..count].sort_unstable_by(|a, b| b.layout_similarity.total_cmp(&a.layout_similarity));
        (candidates, count)
    }

    /// Observes a candidate in both directions of its axis, since a hull looks similar from either end; the observation
    /// with more evidence.
    pub(super) fn resolve_axis_direction(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        observation: Observation,
    ) -> Observation {
        if target.reference.is_none() {
            return observation;
        }
        let angle = observation.pose.angle + core::f32::consts::PI;
        let reversed = self.observe(target, picture, PatchPose { angle, ..observation.pose });
        if reversed.evidence(config, target) > observation.evidence(config, target) {
            target.geometry.reverse_axis();
            return reversed;
        }
        // The following steps sample the crop of the observation that is returned.
        self.observe(target, picture, observation.pose)
    }

    /// Whether a candidate is still recognised: judged by the mean of its observations, so that a single one may be
    /// worse.
    pub(super) fn is_still_recognised(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        observation: &Observation,
    ) -> bool {
        let Some(score) = self.recognition_score(config, target, picture, observation) else { return false };
        target.loss.recognition = target.loss.recognition.with(score);
        target.loss.recognition.mean >= target.min_recognition_score(observation) - CONFIRMING_SLACK
    }

    /// How well an observation matches the target: relative height of the response, relative similarity of the colours
    /// and relative similarity of their layout, in sum about 3 for the target. `None` if the evidence is too weak for a
    /// comparison.
    pub(super) fn recognition_score(
        &mut self,
        config: &FusedConfig,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
    ) -> Option<f32> {
        let height = observation.relative_height(target);
        let is_strong = observation.evidence(config, target) >= config.again as f32
            && height >= MIN_RELATIVE_HEIGHT
            && observation.relative_contrast(target).is_none_or(|share| share >= MIN_RELATIVE_CONTRAST);
        is_strong.then(|| height.min(1.0) + self.relative_similarity(config, target, picture, observation))
    }

    /// Similarity (Bhattacharyya coefficient) of the colours at an observation to the target's, in all and part by
    /// part, each relative to its usual value: in sum about 2 for the target.
    fn relative_similarity(
        &mut self,
        config: &FusedConfig,
        target: &Target,
        picture: &Picture,
        observation: &Observation,
    ) -> f32 {
        let (geometry, appearance) = (&target.geometry, &target.appearance);
        let [inside, ring] = &mut self.histograms;
        let axis = geometry.axis_in(&observation.pose);
        let scale = geometry.scale * observation.pose.step / target.patch_pose(config).step;
        let ellipse = geometry.extent.ellipse(scale, axis);
        count_colours(picture, observation.centre, &ellipse, inside, ring);
        self.layout.count(picture, observation.centre, geometry.extent.half_axes(scale), axis);
        inside.similarity(&appearance.colours.target) / appearance.usual.similarity
            + self.layout.similarity(&appearance.layout) / appearance.usual.layout_similarity
    }

    /// The pose in which the target would lie as the silhouette at the pose's centre does; the direction of the axis is
    /// arbitrary. `None` where there is no reference silhouette or no elongated silhouette of a plausible size.
    fn pose_from_silhouette(&self, target: &Target, pose: &PatchPose) -> Option<PatchPose> {
        let reference = target.reference.as_ref()?;
        let (along, across) = target.geometry.half_axes();
        let long = along.max(across);
        let picture = target.geometry.picture_size();
        let (u, v) = pose.centre;
        if u < long || v < long || u > picture.0 - long || v > picture.1 - long {
            // The border may cut the silhouette off: neither size nor axis can be measured.
            return None;
        }
        let ColourContrast { inside, ring } = self.crop.contrast(pose.centre, (across, across), 0.0);
        let contrast = ColourContrast { inside, ring: ring.min(MAX_RING_SHARE * inside) };
        let radius = SILHOUETTE_RADIUS * long;
        let seen = Silhouette::measure(&self.crop, pose.centre, (radius, radius), 0.0, contrast)?;
        if seen.roundness() > MAX_ROUNDNESS {
            return None;
        }
        let expected = (
            2.0 * along * reference.major / reference.length,
            2.0 * across * reference.minor / reference.breadth,
        );
        let factor = (seen.major * seen.minor / (expected.0 * expected.1)).sqrt();
        (1.0 / MAX_GROWTH..=MAX_GROWTH).contains(&factor).then_some(PatchPose {
            centre: seen.centroid,
            step: pose.step * factor,
            angle: target.geometry.patch_angle + seen.axis - target.geometry.axis,
        })
    }
}

/// One search of a picture.
struct PictureSearch<'a> {
    workspace: &'a mut Workspace,
    config: &'a FusedConfig,
    target: &'a mut Target,
    picture: &'a Picture,
    /// The best observation so far and its evidence.
    best: Option<(Observation, f32)>,
}

impl PictureSearch<'_> {
    /// Observes the best places by colour.
    fn search_by_colour(&mut self, pose: PatchPose) {
        let (candidates, count) = self.workspace.rank_candidates(self.target, self.picture);
        let loss = &mut self.target.loss;
        let other_size = OTHER_SIZES[loss.frames_searched as usize / count.max(1) % OTHER_SIZES.len()];
        let mut candidates = candidates;
        // The best candidate is observed in every frame, the others take turns, so that objects of the target's colour
        // do not keep the target from being observed.
        if count > 2 {
            candidates.swap(1, 1 + loss.frames_searched as usize % (count - 1));
        }
        loss.frames_searched = loss.frames_searched.wrapping_add(1);
        for candidate in &candidates[..count.min(COLOUR_CANDIDATES)] {
            let first = PatchPose { centre: candidate.centre, ..pose };
            self.consider(first);
            if let Some(guess) = self.workspace.pose_from_silhouette(self.target, &first) {
                for half_turn in [0.0, core::f32::consts::PI] {
                    self.consider(PatchPose { angle: guess.angle + half_turn, ..guess });
                }
            } else {
                // The candidate's own size; where that is the expected one, another size in each frame.
                let size = if candidate.scale == 1.0 { other_size } else { candidate.scale };
                self.consider(PatchPose { step: first.step * size, ..first });
            }
        }
    }

    /// Observes a search window, and keeps the observation if it has more evidence than the best so far and is
    /// recognised as the target.
    fn consider(&mut self, pose: PatchPose) {
        let Self { workspace, config, target, picture, best } = self;
        let observation = workspace.observe(target, picture, pose);
        target.confidence = target.confidence.max(rejected_confidence(&observation, target));
        let evidence = observation.evidence(config, target);
        if target.loss.excluded.contains(observation.centre)
            || target.scene.is_of_another(observation.centre, target.geometry.size_px())
        {
            return;
        }
        if best.is_none_or(|(_, most)| evidence > most)
            && let Some(score) = workspace.recognition_score(config, target, picture, &observation)
            && score >= target.min_recognition_score(&observation)
        {
            target.loss.recognition = RecognitionScore::default().with(score);
            *best = Some((observation, evidence));
        }
    }
}

/// Centre of the next window of the systematic search over the whole picture, pixels.
fn next_scan_centre(target: &mut Target, side: f32) -> (f32, f32) {
    let picture = target.geometry.picture_size();
    let count = |length: f32| ((length / (SCAN_SPACING * side)).ceil() as u32).max(1);
    let (across, down) = (count(picture.0), count(picture.1));
    let all = across * down;
    // A stride that is coprime to the number of windows visits all of them.
    let stride = SCAN_STRIDES.into_iter().find(|stride| !all.is_multiple_of(*stride)).unwrap_or(1);
    let index = target.loss.scan_index.wrapping_add(stride) % all;
    target.loss.scan_index = index;
    let at = |index: u32, count: u32, length: f32| (index as f32 + 0.5) * length / count as f32;
    (at(index % across, across, picture.0), at(index / across, down, picture.1))
}
