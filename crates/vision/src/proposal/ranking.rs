//! Which of several boxes at a point is that of the object.
//!
//! The score of a candidate is a logistic regression on [`FEATURES`] figures of the candidate and of its
//! relation to the others. The weights were fitted to labelled recordings and generated scenes: a box is
//! right if its IoU with the label is at least 0.5.

use barrelman_vocab::{PixelBox, PixelPoint};

/// A box that may be the object's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    /// The box, pixels.
    pub(super) bounds: PixelBox,
    /// Side of the seed that led to the box, pixels.
    pub(super) seed_px: f32,
    /// Probability of the box by the network, 0 to 1.
    pub(super) probability: f32,
    /// Sum of the expected errors of the edges, in sides of the window's box.
    pub(super) error: f32,
    /// IoU of the box with the one that was refined.
    pub(super) kept: f32,
    /// Similarity of the colours in the box and in the ring around it, 0 to 1.
    pub(super) similarity_to_ring: f32,
    /// Similarity of the colours in the ring and in the whole picture, 0 to 1.
    pub(super) ring_similarity: f32,
    /// Mean logarithm of the frequency in the whole picture of the colours in the ring.
    pub(super) ring_loss: f32,
    /// Mean negative logarithm of the frequency in the ring of the colours in the box.
    pub(super) distinction: f32,
    /// Whether the box was refined once more.
    pub(super) is_refined: bool,
    /// Score, 0 to 1; set by [`rank`].
    pub(super) score: f32,
}

/// What is searched where.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene {
    /// The point, pixels.
    pub(super) at: PixelPoint,
    /// Height of the picture, pixels.
    pub(super) height_px: f32,
}

/// Number of figures of a candidate.
const FEATURES: usize = 14;
/// Weights of the figures.
const WEIGHTS: [f32; FEATURES] =
    [0.667, 0.194, 1.533, -0.149, -0.101, -2.349, 2.909, -12.731, 1.395, 0.795, 0.306, 0.751, 4.289, 0.501];
/// Offset of the log-odds.
const OFFSET: f32 = -10.002;
/// Share of a box within another that is a part of it, and minimum ratio of the areas.
const MIN_CONTAINED: f64 = 0.85;
const MIN_AREA_RATIO: f64 = 1.6;

/// Sets the scores, and sorts by them in descending order.
pub(super) fn rank(candidates: &mut [Candidate], scene: Scene) {
    for index in 0..candidates.len() {
        let figures = figures(candidates, index, scene);
        let log_odds =
            OFFSET + figures.iter().zip(WEIGHTS).map(|(figure, weight)| figure * weight).sum::<f32>();
        candidates[index].score = 1.0 / (1.0 + libm::expf(-log_odds));
    }
    candidates.sort_unstable_by(|a, b| b.score.total_cmp(&a.score));
}

/// The figures of a candidate.
fn figures(candidates: &[Candidate], index: usize, scene: Scene) -> [f32; FEATURES] {
    let this = &candidates[index];
    let bounds = this.bounds;
    let size = bounds.area().sqrt() as f32;
    let off = |at: f64, from: f64, side: f64| ((at - from) / side - 0.5).abs() as f32;
    let off = off(scene.at.u, bounds.u, bounds.w).max(off(scene.at.v, bounds.v, bounds.h));
    let probability = this.probability.clamp(1e-4, 1.0 - 1e-4);
    let (mut within, mut around) = (0.0_f32, 0.0_f32);
    for other in candidates {
        let shared = bounds.intersection(other.bounds).area();
        let is_part = |part: PixelBox, whole: PixelBox| {
            shared > MIN_CONTAINED * part.area() && whole.area() > MIN_AREA_RATIO * part.area()
        };
        if is_part(bounds, other.bounds) {
            around = around.max(other.probability);
        } else if is_part(other.bounds, bounds) {
            within = within.max(other.probability);
        }
    }
    [
        libm::logf(probability / (1.0 - probability)),
        this.error,
        support(candidates, bounds),
        libm::logf(size / scene.height_px),
        libm::logf(size / this.seed_px),
        this.kept,
        off,
        (off - 0.5).clamp(0.0, 2.0),
        libm::logf((bounds.w / bounds.h) as f32).abs(),
        around,
        within,
        this.ring_similarity,
        this.similarity_to_ring,
        this.ring_loss + this.distinction,
    ]
}

/// How many seeds led to a box: the sum, over the seeds, of the largest product of probability and IoU.
fn support(candidates: &[Candidate], bounds: PixelBox) -> f32 {
    let worth = |other: &Candidate| other.probability * bounds.iou(other.bounds) as f32;
    let is_best_of_seed = |index: usize, this: &Candidate| {
        let is_better = |(other_index, other): (usize, &Candidate)| {
            other.seed_px == this.seed_px
                && (worth(other) > worth(this) || worth(other) == worth(this) && other_index < index)
        };
        !candidates.iter().enumerate().any(is_better)
    };
    let best = candidates.iter().enumerate().filter(|(index, this)| is_best_of_seed(*index, this));
    best.map(|(_, this)| worth(this)).sum()
}
