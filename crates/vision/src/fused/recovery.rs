//! Looking for a lost target everywhere, a bounded number of looks per frame.

use barrelman_vocab::Picture;

use super::Eyes;
use super::config::FusedConfig;
use super::evidence::{Look, TELLING_CONTRAST, confidence_disbelieved};
use super::target::{Recognition, Target};
use crate::colour_model::count_colours;
use crate::features::Place;
use crate::redetection::{CANDIDATES, Candidate};
use crate::silhouette::Silhouette;

/// Candidates told by colour that are looked at in one frame.
const BY_COLOUR: usize = 2;
/// Windows of the systematic search lie this share of their side apart.
const SCAN_SHARE: f32 = 0.4;
/// The systematic search goes on by so many windows (a prime), so that neighbours are not looked at one after the
/// other.
const SCAN_STRIDES: [u32; 4] = [7, 11, 13, 17];
/// Least height of the response and contrast of the colour, in what is usual, for a look to be worth a comparison.
const LEAST_HEIGHT: f32 = 0.3;
const LEAST_COLOUR: f32 = 0.2;
/// By how much less alike than when it was found a target may be, on the mean, while it is confirmed.
const SLACK: f32 = 0.07;
/// The colour's axis is measured within a circle of this many half lengths around a candidate.
const REACH: f32 = 1.3;
/// Sizes that are tried for a target without an outline, in its own.
const OTHER_SIZES: [f32; 2] = [0.75, 1.33];
/// By what factor a target may have grown or shrunk while it was lost.
const MOST_GROWTH: f32 = 1.7;
/// What is rounder than this has no axis.
const ROUND: f32 = 0.8;

impl Eyes {
    /// The best look that may be the target, if there is one.
    pub(super) fn search_everywhere(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
    ) -> Option<Look> {
        let place = target.place(config);
        let bounds = target.bounds();
        target.motion.0.slow_down(bounds.0);
        target.motion.1.slow_down(bounds.1);
        target.confidence = 0.0;
        let mut best = None;
        for centre in
            [(target.motion.0.place as f32, target.motion.1.place as f32), next_window(target, place.side())]
        {
            let look = self.look(target, picture, Place { centre, ..place });
            self.consider(config, target, picture, look, &mut best);
        }
        if target.contrast > TELLING_CONTRAST {
            let upright = target.extent.upright(target.scale, target.axis);
            let found = self.redetection.look(picture, &target.colours, upright);
            let mut candidates = [Candidate::default(); CANDIDATES];
            let count = found.len();
            candidates[..count].copy_from_slice(found);
            let half = target.half_axes();
            for candidate in &mut candidates[..count] {
                let half = (half.0 * candidate.growth, half.1 * candidate.growth);
                self.layout.count(picture, candidate.centre, half, target.axis);
                candidate.worth = self.layout.overlap(&target.layout);
            }
            candidates[..count].sort_unstable_by(|a, b| b.worth.total_cmp(&a.worth));
            // The best is looked at in every frame, the others take turns: things of its colour must not stand in
            // its way.
            let other = OTHER_SIZES[target.searched as usize / count.max(1) % OTHER_SIZES.len()];
            if count > 2 {
                candidates.swap(1, 1 + target.searched as usize % (count - 1));
            }
            target.searched = target.searched.wrapping_add(1);
            let count = count.min(BY_COLOUR);
            for candidate in &candidates[..count] {
                let first = Place { centre: candidate.centre, ..place };
                let look = self.look(target, picture, first);
                self.consider(config, target, picture, look, &mut best);
                if let Some(guess) = self.guess(target, &first) {
                    for half_turn in [0.0, core::f32::consts::PI] {
                        let look =
                            self.look(target, picture, Place { angle: guess.angle + half_turn, ..guess });
                        self.consider(config, target, picture, look, &mut best);
                    }
                } else {
                    // It is as large as what has its colour there; where that is as large as expected, another size
                    // is tried in each frame.
                    let size = if candidate.growth == 1.0 { other } else { candidate.growth };
                    let look = self.look(target, picture, Place { step: first.step * size, ..first });
                    self.consider(config, target, picture, look, &mut best);
                }
            }
        }
        best.map(|(look, _)| look)
    }

    /// Keeps the look with the most evidence of those that may be at the target.
    fn consider(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        look: Look,
        best: &mut Option<(Look, f32)>,
    ) {
        target.confidence = target.confidence.max(confidence_disbelieved(&look, target));
        let evidence = look.evidence(config, target);
        if best.is_none_or(|(_, most)| evidence > most)
            && let Some(alike) = self.alike(config, target, picture, &look)
            && alike >= target.alike_enough(&look)
        {
            target.recognition = Recognition::default().with(alike);
            *best = Some((look, evidence));
        }
    }

    /// A hull looks much the same from bow to stern as from stern to bow: takes the way round that fits better.
    pub(super) fn better_way_round(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        look: Look,
    ) -> Look {
        if target.outline.is_none() {
            return look;
        }
        let turned = Place { angle: look.place.angle + core::f32::consts::PI, ..look.place };
        let other = self.look(target, picture, turned);
        if other.evidence(config, target) > look.evidence(config, target) {
            target.turn_about();
            return other;
        }
        // What comes after samples the crop of the look that is taken.
        self.look(target, picture, look.place)
    }

    /// Whether a target that was perhaps found again still is what it was taken for: all looks together must say so,
    /// where one may be worse than another.
    pub(super) fn still_recognises(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        look: &Look,
    ) -> bool {
        let Some(alike) = self.alike(config, target, picture, look) else { return false };
        target.recognition = target.recognition.with(alike);
        target.recognition.alike >= target.alike_enough(look) - SLACK
    }

    /// How alike to the target what a look shows is: by the pattern, by its colours, and by where they lie, each in
    /// what is usual. None where too little speaks for it to be worth a comparison.
    fn alike(
        &mut self,
        config: &FusedConfig,
        target: &Target,
        picture: &Picture,
        look: &Look,
    ) -> Option<f32> {
        let height = look.height(target);
        let worth = look.evidence(config, target) >= config.again as f32
            && height >= LEAST_HEIGHT
            && look.colour(target).is_none_or(|share| share >= LEAST_COLOUR);
        worth.then(|| height.min(1.0) + self.kinship(config, target, picture, look))
    }

    /// How alike the colours at a look's place are to the target's, all together and part by part, each in what is
    /// usual: about 2 for the target.
    fn kinship(&mut self, config: &FusedConfig, target: &Target, picture: &Picture, look: &Look) -> f32 {
        let [inside, around] = &mut self.colours;
        let axis = target.axis_at(&look.place);
        let scale = target.scale * look.place.step / target.place(config).step;
        count_colours(picture, look.centre, &target.extent.region(scale, axis), inside, around);
        self.layout.count(picture, look.centre, target.extent.half_axes(scale), axis);
        inside.overlap(&target.colours.target) / target.kinship
            + self.layout.overlap(&target.layout) / target.layout_kinship
    }

    /// How a patch must be turned and scaled for the target to lie as what has its colour there, one way round.
    fn guess(&self, target: &Target, place: &Place) -> Option<Place> {
        let outline = target.outline.as_ref()?;
        let (along, across) = target.half_axes();
        let long = along.max(across);
        let bounds = target.bounds();
        let (u, v) = place.centre;
        if u < long || v < long || u > bounds.0 - long || v > bounds.1 - long {
            // Of what is cut off by the border, neither size nor axis can be told.
            return None;
        }
        let (inside, ring) = self.crop.contrast(place.centre, (across, across), 0.0);
        let round = REACH * long;
        let seen =
            Silhouette::of(&self.crop, place.centre, (round, round), 0.0, (inside, ring.min(0.5 * inside)))?;
        if seen.roundness() > ROUND {
            return None;
        }
        let known =
            (2.0 * along * outline.major / outline.length, 2.0 * across * outline.minor / outline.breadth);
        let factor = (seen.major * seen.minor / (known.0 * known.1)).sqrt();
        (1.0 / MOST_GROWTH..=MOST_GROWTH).contains(&factor).then_some(Place {
            centre: seen.centroid,
            step: place.step * factor,
            angle: target.angle + seen.axis - target.axis,
        })
    }
}

/// The next window of the search over the whole picture.
fn next_window(target: &mut Target, side: f32) -> (f32, f32) {
    let bounds = target.bounds();
    let count = |length: f32| ((length / (SCAN_SHARE * side)).ceil() as u32).max(1);
    let (across, down) = (count(bounds.0), count(bounds.1));
    let all = across * down;
    // A stride that shares no factor with the count comes by every window.
    let stride = SCAN_STRIDES.into_iter().find(|stride| !all.is_multiple_of(*stride)).unwrap_or(1);
    target.scan = target.scan.wrapping_add(stride) % all;
    let at = |index: u32, count: u32, length: f32| (index as f32 + 0.5) * length / count as f32;
    (at(target.scan % across, across, bounds.0), at(target.scan / across, down, bounds.1))
}
