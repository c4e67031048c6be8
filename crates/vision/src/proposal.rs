//! The object at a point of the picture: from a tap to a box.
//!
//! Neither the object's size nor its middle is known. The search therefore begins with squares of several
//! sizes around the point (the *seeds*), and, for each, with the component of the colour that distinguishes
//! the square from its surroundings. The refinement network turns each of these boxes into the box of an
//! object with a probability. The best of the results are refined once more. What is proposed is the
//! candidate with the highest score ([`ranking`]): many seeds lead to a whole object, few to a part of it.
//!
//! Not handled: an object that cannot be told from its surroundings in a single picture.

mod ranking;

use core::fmt;

use barrelman_vocab::{Picture, PixelBox, PixelPoint};

use crate::colour_model::{ColourHistogram, ColourModel, TargetEllipse, count_colours, count_picture};
use crate::components::ComponentFinder;
use crate::crop::Crop;
use crate::refinement::{
    MotionReferences, RefinedBox, RefinementNetwork, RefinementWeights, RefinementWindow, WindowContext,
    WindowMemory,
};
use ranking::{Candidate, Scene, rank};

/// Ratio of the sizes of neighbouring seeds.
const SEED_RATIO: f32 = 1.8;
/// Maximum number of seeds.
const MAX_SEEDS: usize = 8;
/// Numbers of candidates that are refined once more, in each of the rounds after the first.
const REFINED_AGAIN: [usize; 2] = [5, 3];
/// Maximum IoU of two candidates of which both are refined once more in a round.
const MAX_SHARED: f64 = 0.7;
/// Minimum score of a proposal. With weights that were fitted to every second recording, 80 % of the taps on
/// boats and people on water in the others give a box with an IoU of at least 0.5, 2 % another object, and
/// 1 % nothing; of taps on water without an object, 92 % give nothing.
const MIN_SCORE: f32 = 0.35;
/// Minimum side of a candidate, pixels.
const MIN_SIDE_PX: f64 = 2.0;
/// Reach of the crop around the centre of a box, in longer sides of the box, and samples along such a side.
const CROP_REACH: f32 = 1.5;
const CROP_SAMPLES: f32 = 26.0;
/// Maximum distance of a component from the point, in sizes of the seed.
const MAX_COMPONENT_DISTANCE: f64 = 0.5;
/// What a distance from the point costs a component, relative to its size.
const COMPONENT_DISTANCE_COST: f64 = 1.5;

/// How the network evaluates a window.
type Evaluation = fn(&mut RefinementNetwork, &RefinementWindow) -> RefinedBox;

/// The sizes that an object may have in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectSizes {
    /// Root of the area of the smallest box, pixels.
    pub min_px: f32,
    /// Root of the area of the largest box, pixels.
    pub max_px: f32,
}

impl ObjectSizes {
    /// Sizes in a picture of this height where nothing is known of distances: from a head in the water far
    /// away to a boat that fills half of the picture.
    pub fn in_picture_of_height(height: u32) -> Self {
        let max_px = 0.5 * height as f32;
        Self { min_px: 8.0_f32.min(max_px), max_px }
    }
}

/// A proposed object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal {
    /// Its box, pixels.
    pub bounds: PixelBox,
    /// Score of the box, 0 to 1.
    pub score: f64,
}

/// Why no object is proposed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NoProposal {
    /// The point lies outside the picture.
    OutsidePicture,
    /// No object differs clearly from its surroundings.
    NothingStandsOut,
}

impl fmt::Display for NoProposal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OutsidePicture => "the point lies outside the picture",
            Self::NothingStandsOut => "nothing stands out here",
        })
    }
}

/// Proposes objects; keeps its buffers.
#[derive(Debug)]
pub struct Proposer {
    /// Colours of the whole picture.
    scene: ColourHistogram,
    /// Colours in and around the last box.
    colours: ColourModel,
    crop: Crop,
    components: ComponentFinder,
    window: RefinementWindow,
    network: RefinementNetwork,
    /// What the network reads of earlier frames: nothing.
    memory: WindowMemory,
    references: MotionReferences,
    candidates: Vec<Candidate>,
}

impl Default for Proposer {
    fn default() -> Self {
        Self {
            scene: ColourHistogram::default(),
            colours: ColourModel::default(),
            crop: Crop::default(),
            components: ComponentFinder::default(),
            window: RefinementWindow::default(),
            network: RefinementNetwork::new(RefinementWeights::built_in()),
            memory: WindowMemory::default(),
            references: MotionReferences::default(),
            candidates: Vec::with_capacity(2 * MAX_SEEDS + REFINED_AGAIN.iter().sum::<usize>()),
        }
    }
}

impl Proposer {
    /// The object at a point, pixels.
    ///
    /// # Errors
    /// If there is none of these sizes.
    pub fn propose(
        &mut self,
        picture: &Picture,
        at: PixelPoint,
        sizes: ObjectSizes,
    ) -> Result<Proposal, NoProposal> {
        let size = picture.size();
        let is_inside = |place: f64, length: u32| (0.0..f64::from(length)).contains(&place);
        if !is_inside(at.u, size.width) || !is_inside(at.v, size.height) {
            return Err(NoProposal::OutsidePicture);
        }
        count_picture(picture, &mut self.scene);
        self.candidates.clear();
        let mut seed_px = sizes.min_px;
        for _ in 0..MAX_SEEDS {
            if seed_px > sizes.max_px {
                break;
            }
            self.add_seed(picture, at, seed_px);
            seed_px *= SEED_RATIO;
        }
        for count in REFINED_AGAIN {
            self.refine_best_again(picture, at, count);
        }
        let scene = Scene { at, height_px: size.height as f32 };
        rank(&mut self.candidates, scene);
        let best = self.candidates.first().filter(|best| best.score >= MIN_SCORE);
        let best = best.ok_or(NoProposal::NothingStandsOut)?;
        Ok(Proposal { bounds: best.bounds, score: f64::from(best.score) })
    }

    /// Adds the candidates of a square of this side around the point.
    fn add_seed(&mut self, picture: &Picture, at: PixelPoint, seed_px: f32) {
        let square = square_around(at, f64::from(seed_px)).clipped(picture.size());
        self.add_candidate(picture, square, seed_px, RefinementNetwork::evaluate_upright);
        if let Some(component) = self.component(square, at)
            && component.w >= MIN_SIDE_PX
            && component.h >= MIN_SIDE_PX
        {
            let component = component.clipped(picture.size());
            self.add_candidate(picture, component, seed_px, RefinementNetwork::evaluate_upright);
        }
    }

    /// The component of the last crop's colour that is at the point, or near.
    fn component(&mut self, square: PixelBox, at: PixelPoint) -> Option<PixelBox> {
        let side = square.area().sqrt();
        let mut best: Option<(f64, PixelBox)> = None;
        for component in self.components.find(&self.crop) {
            let bounds = component.bounds;
            let right = (bounds.u - at.u).max(at.u - bounds.u - bounds.w).max(0.0);
            let down = (bounds.v - at.v).max(at.v - bounds.v - bounds.h).max(0.0);
            let distance = libm::hypot(right, down) / side;
            let worth = f64::from(component.area).sqrt() / side - COMPONENT_DISTANCE_COST * distance;
            if distance < MAX_COMPONENT_DISTANCE && best.is_none_or(|(most, _)| worth > most) {
                best = Some((worth, bounds));
            }
        }
        best.map(|(_, bounds)| bounds)
    }

    /// Refines so many of those candidates again that rank highest and differ from each other.
    fn refine_best_again(&mut self, picture: &Picture, at: PixelPoint, count: usize) {
        let scene = Scene { at, height_px: picture.size().height as f32 };
        rank(&mut self.candidates, scene);
        let first_new = self.candidates.len();
        for index in 0..first_new {
            let candidate = self.candidates[index];
            let is_near = |other: &Candidate| other.bounds.iou(candidate.bounds) > MAX_SHARED;
            if candidate.is_refined || self.candidates[..index].iter().any(is_near) {
                continue;
            }
            self.candidates[index].is_refined = true;
            self.add_candidate(picture, candidate.bounds, candidate.seed_px, RefinementNetwork::evaluate);
            if self.candidates.len() >= first_new + count {
                return;
            }
        }
    }

    /// Refines a box that came from a seed of this side, and adds the result.
    fn add_candidate(&mut self, picture: &Picture, start: PixelBox, seed_px: f32, evaluate: Evaluation) {
        let size = picture.size();
        let refined = self.refined(picture, start, evaluate);
        let bounds = refined.bounds().clipped(size);
        if bounds.w < MIN_SIDE_PX || bounds.h < MIN_SIDE_PX {
            return;
        }
        let ColourModel { target, surroundings, .. } = &mut self.colours;
        let (centre, sides) = centre_and_sides(bounds);
        count_colours(picture, centre, &TargetEllipse::inscribed_in(sides), target, surroundings);
        self.candidates.push(Candidate {
            bounds,
            seed_px,
            probability: refined.probability,
            error: refined.errors.iter().sum(),
            kept: start.iou(bounds) as f32,
            similarity_to_ring: target.similarity(surroundings),
            ring_similarity: surroundings.similarity(&self.scene),
            ring_loss: surroundings.mean_logarithm_in(&self.scene),
            distinction: -target.mean_logarithm_in(surroundings),
            is_refined: false,
            score: 0.0,
        });
    }

    /// The network's answer for a box.
    fn refined(&mut self, picture: &Picture, start: PixelBox, evaluate: Evaluation) -> RefinedBox {
        let (centre, sides) = centre_and_sides(start);
        let ColourModel { target, surroundings, .. } = &mut self.colours;
        count_colours(picture, centre, &TargetEllipse::inscribed_in(sides), target, surroundings);
        self.colours.update_table();
        let longer = sides.0.max(sides.1);
        self.crop.extract(picture, &self.colours, centre, CROP_REACH * longer, longer / CROP_SAMPLES);
        let size = picture.size();
        let context = WindowContext {
            tracked: centre,
            picture: (size.width as f32, size.height as f32),
            memory: &self.memory,
            references: &self.references,
        };
        self.window.measure(&mut self.crop, centre, sides, context);
        evaluate(&mut self.network, &self.window)
    }
}

/// The square of this side around a point, pixels.
fn square_around(at: PixelPoint, side: f64) -> PixelBox {
    PixelBox { u: at.u - 0.5 * side, v: at.v - 0.5 * side, w: side, h: side }
}

/// Centre, and width and height, of a box, pixels.
fn centre_and_sides(bounds: PixelBox) -> ((f32, f32), (f32, f32)) {
    let centre = bounds.centre();
    ((centre.u as f32, centre.v as f32), (bounds.w as f32, bounds.h as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::painted;

    const SIZE: (u32, u32) = (640, 360);
    const WATER: [u8; 3] = [90, 150, 112];

    /// Water with waves, and an object (left, top, width, height) of one colour.
    fn picture(object: Option<([usize; 4], [u8; 3])>) -> Picture {
        painted(SIZE, |column, row| {
            let is_inside = |[left, top, w, h]: [usize; 4]| {
                (left..left + w).contains(&column) && (top..top + h).contains(&row)
            };
            match object {
                Some((place, colour)) if is_inside(place) => colour,
                _ => {
                    let wave = libm::sin(column as f64 * 0.31 + libm::sin(row as f64 * 0.17) * 2.0);
                    [(f64::from(WATER[0]) + 8.0 * wave) as u8, WATER[1], WATER[2]]
                }
            }
        })
    }

    fn proposed(picture: &Picture, (u, v): (f64, f64)) -> Result<Proposal, NoProposal> {
        let sizes = ObjectSizes::in_picture_of_height(SIZE.1);
        Proposer::default().propose(picture, PixelPoint { u, v }, sizes)
    }

    #[test]
    fn a_tap_on_or_beside_the_middle_of_an_object_gives_its_box() {
        let objects = [
            ([300, 160, 40, 20], [80, 90, 220]),
            ([100, 80, 24, 60], [210, 40, 150]),
            ([420, 200, 90, 44], [235, 128, 128]),
            ([200, 250, 60, 30], [25, 128, 128]),
        ];
        for (place, colour) in objects {
            let picture = picture(Some((place, colour)));
            let [u, v, w, h] = place.map(|length| length as f64);
            let truth = PixelBox { u, v, w, h };
            let middle = truth.centre();
            for (right, down) in [(0.0, 0.0), (0.25, 0.0), (-0.25, 0.25), (0.0, -0.25)] {
                let found = proposed(&picture, (middle.u + right * w, middle.v + down * h));
                let iou = found.map_or(0.0, |found| found.bounds.iou(truth));
                assert!(iou >= 0.5, "{place:?} {colour:?} {right} {down}: {found:?}");
            }
        }
    }

    #[test]
    fn a_tap_on_water_gives_nothing() {
        let water = picture(None);
        for at in [(60.0, 40.0), (320.0, 180.0), (600.0, 300.0)] {
            assert_eq!(proposed(&water, at), Err(NoProposal::NothingStandsOut), "{at:?}");
        }
    }

    #[test]
    fn a_tap_beside_the_picture_is_refused() {
        for at in [(-1.0, 10.0), (640.0, 10.0), (10.0, 360.0), (f64::NAN, 10.0)] {
            assert_eq!(proposed(&picture(None), at), Err(NoProposal::OutsidePicture), "{at:?}");
        }
    }

    #[test]
    fn an_object_of_a_size_that_is_not_possible_is_not_proposed() {
        let picture = picture(Some(([300, 160, 40, 20], [80, 90, 220])));
        let sizes = ObjectSizes { min_px: 200.0, max_px: 100.0 };
        let at = PixelPoint { u: 320.0, v: 170.0 };
        assert_eq!(Proposer::default().propose(&picture, at, sizes), Err(NoProposal::NothingStandsOut));
    }

    #[test]
    fn pictures_of_any_size_can_be_tapped() {
        let mut proposer = Proposer::default();
        for size in [(0, 0), (1, 1), (2, 2), (3, 9), (40, 1), (33, 31)] {
            let picture = painted(size, |column, row| [(31 * column + 17 * row) as u8, 128, 128]);
            let sizes = ObjectSizes::in_picture_of_height(size.1);
            let at = PixelPoint { u: f64::from(size.0) * 0.5, v: f64::from(size.1) * 0.5 };
            assert!(proposer.propose(&picture, at, sizes).is_err(), "{size:?}");
        }
    }

    #[test]
    fn an_earlier_tap_does_not_change_the_answer() {
        let boat = picture(Some(([300, 160, 40, 20], [80, 90, 220])));
        let (at, sizes) = (PixelPoint { u: 320.0, v: 170.0 }, ObjectSizes::in_picture_of_height(SIZE.1));
        let mut proposer = Proposer::default();
        let first = proposer.propose(&boat, at, sizes);
        let _ = proposer.propose(&picture(None), PixelPoint { u: 100.0, v: 100.0 }, sizes);
        assert_eq!(proposer.propose(&boat, at, sizes), first);
    }
}
