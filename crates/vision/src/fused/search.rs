//! The stage that searches the whole picture for a lost target, with a bounded number of observations per
//! frame.
//!
//! Input: the target's model, the prediction and the picture. Output: the observation that is recognised as
//! the target, if there is one, and the confidence of the best observation.

use barrelman_vocab::{Picture, Timestamp};

use super::confidence::Confidence;
use super::excluded_places::ExcludedPlaces;
use super::known_scene::KnownScene;
use super::observation::Observation;
use super::observer::Observer;
use super::ratio::is_within;
use super::recognition::Recognition;
use super::target::Target;
use crate::crop::Crop;
use crate::features::PatchPose;
use crate::layout::ColourLayout;
use crate::probability_view::ColourContrast;
use crate::redetection::{Candidate as ColourCandidate, MAX_CANDIDATES, Redetector};
use crate::silhouette::Silhouette;

/// Strides of the systematic search (primes), so that consecutive windows are not neighbours.
const SCAN_STRIDES: [u32; 4] = [7, 11, 13, 17];

/// Settings of the search. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct SearchSettings {
    /// Maximum number of places by colour that are observed in one frame.
    colour_candidates: usize,
    /// Distance of neighbouring windows of the systematic search, sides of the window.
    scan_spacing: f32,
    /// Radius of the circle around a place in which its silhouette is measured, half lengths of the target.
    silhouette_radius: f32,
    /// Sizes at which a target without a reference silhouette is looked for, relative to its own.
    other_sizes: [f32; 2],
    /// Maximum factor by which a target may grow or shrink while it is lost.
    max_growth: f32,
    /// Maximum ratio of minor to major axis of a silhouette that gives the axis, 0 to 1.
    max_roundness: f32,
    /// Upper bound of the target probability around a place, relative to that inside.
    max_ring_share: f32,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self {
            colour_candidates: 2,
            scan_spacing: 0.4,
            silhouette_radius: 1.3,
            other_sizes: [0.75, 1.33],
            max_growth: 1.7,
            max_roundness: 0.8,
            max_ring_share: 0.5,
        }
    }
}

/// The search for a lost target, with its buffers.
#[derive(Debug)]
pub(super) struct Search {
    settings: SearchSettings,
    redetector: Redetector,
    layout: ColourLayout,
    /// Number of frames searched by colour since the loss.
    frames_searched: u32,
    /// Index of the next window of the systematic search.
    scan_index: u32,
    /// Places of objects that the operator rejected, in the present frame.
    pub(super) excluded: ExcludedPlaces,
}

/// The inputs of a search.
pub(super) struct SearchInput<'a> {
    pub(super) observer: &'a mut Observer,
    pub(super) recognition: &'a mut Recognition,
    pub(super) scene: &'a mut KnownScene,
    pub(super) confidence: &'a Confidence,
    pub(super) target: &'a Target,
    pub(super) picture: &'a Picture,
    pub(super) now: Timestamp,
}

/// The result of a search in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SearchResult {
    /// The observation with the most evidence among those that are recognised as the target.
    pub(super) observation: Option<Observation>,
    /// Confidence of the best observation.
    pub(super) confidence: f64,
}

impl Search {
    pub(super) fn new() -> Self {
        Self {
            settings: SearchSettings::default(),
            redetector: Redetector::default(),
            layout: ColourLayout::default(),
            frames_searched: 0,
            scan_index: 0,
            excluded: ExcludedPlaces::default(),
        }
    }

    /// Begins with a target that is selected.
    pub(super) fn select(&mut self) {
        (self.frames_searched, self.scan_index) = (0, 0);
        self.excluded = ExcludedPlaces::default();
    }

    /// Begins the search after a loss.
    pub(super) fn restart(&mut self) {
        self.frames_searched = 0;
    }

    /// Searches a frame; the target is expected at `place`, pixels.
    pub(super) fn run(&mut self, mut input: SearchInput<'_>, place: (f32, f32)) -> SearchResult {
        let pose = input.observer.patch_pose(input.target);
        let mut result = SearchResult::default();
        for centre in [place, self.next_scan_centre(input.target, pose.side_px())] {
            self.consider(&mut input, &mut result, PatchPose { centre, ..pose });
        }
        if input.target.appearance.usual.is_colour_used() {
            self.search_by_colour(&mut input, &mut result, pose);
        }
        result
    }

    /// Observes the best candidates by colour.
    fn search_by_colour(&mut self, input: &mut SearchInput<'_>, result: &mut SearchResult, pose: PatchPose) {
        let (mut candidates, count) = self.rank_candidates(input.target, input.picture);
        let sizes = self.settings.other_sizes;
        let searched = self.frames_searched as usize;
        let other_size = sizes[searched / count.max(1) % sizes.len()];
        // The best candidate is observed in every frame. The others take turns, so that the target is
        // observed even if many objects have its colour.
        if count > 2 {
            candidates.swap(1, 1 + searched % (count - 1));
        }
        self.frames_searched = self.frames_searched.wrapping_add(1);
        for candidate in &candidates[..count.min(self.settings.colour_candidates)] {
            let first = PatchPose { centre: candidate.centre, ..pose };
            self.consider(input, result, first);
            if let Some(guess) = self.pose_from_silhouette(input, &first) {
                for half_turn in [0.0, core::f32::consts::PI] {
                    self.consider(input, result, PatchPose { angle: guess.angle + half_turn, ..guess });
                }
            } else {
                // The candidate's own size. If that is the expected one, another size in each frame.
                let size = if candidate.scale == 1.0 { other_size } else { candidate.scale };
                self.consider(input, result, PatchPose { step: first.step * size, ..first });
            }
        }
    }

    /// Observes a search window, and keeps the observation if it has more evidence than the best so far and
    /// is recognised as the target.
    fn consider(&self, input: &mut SearchInput<'_>, result: &mut SearchResult, pose: PatchPose) {
        let SearchInput { target, picture, now, .. } = *input;
        let observation = input.observer.observe(target, picture, pose);
        result.confidence = result.confidence.max(input.confidence.of_rejected(&observation, target));
        if self.excluded.contains(observation.centre)
            || input.scene.is_excluded_object(observation.centre, target.geometry.size_px())
        {
            return;
        }
        if result.observation.is_none_or(|best| observation.evidence > best.evidence)
            && input.recognition.recognise(target, picture, &observation, now)
        {
            result.observation = Some(observation);
        }
    }

    /// Candidates by colour, sorted by the similarity of their layout to the target's, and their number.
    pub(super) fn rank_candidates(
        &mut self,
        target: &Target,
        picture: &Picture,
    ) -> ([ColourCandidate; MAX_CANDIDATES], usize) {
        let Target { geometry, appearance, .. } = target;
        let found = self.redetector.find_candidates(picture, &appearance.colours, geometry.upright_box());
        let mut candidates = [ColourCandidate::default(); MAX_CANDIDATES];
        let count = found.len();
        candidates[..count].copy_from_slice(found);
        let half = geometry.half_axes();
        for candidate in &mut candidates[..count] {
            let half = (half.0 * candidate.scale, half.1 * candidate.scale);
            self.layout.count(picture, candidate.centre, half, geometry.axis);
            candidate.layout_similarity = self.layout.similarity(&appearance.layout);
        }
        candidates[..count].sort_unstable_by(|a, b| b.layout_similarity.total_cmp(&a.layout_similarity));
        (candidates, count)
    }

    /// The pose of a target that has the silhouette at the pose's centre; the direction of the axis is
    /// arbitrary. `None` if there is no reference silhouette, or no elongated silhouette of a plausible size.
    fn pose_from_silhouette(&self, input: &SearchInput<'_>, pose: &PatchPose) -> Option<PatchPose> {
        let (settings, geometry) = (&self.settings, &input.target.geometry);
        let reference = input.target.reference.as_ref()?;
        let crop: &Crop = &input.observer.crop;
        let (along, across) = geometry.half_axes();
        let long = geometry.longer_half_axis();
        if geometry.is_cut_off(pose.centre, (long, long)) {
            // The border may cut the silhouette off, so that size and axis cannot be measured.
            return None;
        }
        let ColourContrast { inside, ring } = crop.contrast(pose.centre, (across, across), 0.0);
        let contrast = ColourContrast { inside, ring: ring.min(settings.max_ring_share * inside) };
        let radius = settings.silhouette_radius * long;
        let seen = Silhouette::measure(crop, pose.centre, (radius, radius), 0.0, contrast)?;
        if seen.roundness() > settings.max_roundness {
            return None;
        }
        let expected = (
            2.0 * along * reference.major / reference.length,
            2.0 * across * reference.minor / reference.breadth,
        );
        let factor = (seen.major * seen.minor / (expected.0 * expected.1)).sqrt();
        is_within(factor, settings.max_growth).then_some(PatchPose {
            centre: seen.centroid,
            step: pose.step * factor,
            angle: geometry.patch_angle + seen.axis - geometry.axis,
        })
    }

    /// Centre of the next window of the systematic search over the whole picture, pixels.
    fn next_scan_centre(&mut self, target: &Target, side: f32) -> (f32, f32) {
        let picture = target.geometry.picture_size();
        let count = |length: f32| ((length / (self.settings.scan_spacing * side)).ceil() as u32).max(1);
        let (across, down) = (count(picture.0), count(picture.1));
        let all = across * down;
        // A stride that is coprime to the number of windows visits all of them.
        let stride = SCAN_STRIDES.into_iter().find(|stride| !all.is_multiple_of(*stride)).unwrap_or(1);
        let index = self.scan_index.wrapping_add(stride) % all;
        self.scan_index = index;
        let at = |index: u32, count: u32, length: f32| (index as f32 + 0.5) * length / count as f32;
        (at(index % across, across, picture.0), at(index / across, down, picture.1))
    }
}
