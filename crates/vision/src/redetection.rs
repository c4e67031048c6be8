//! Re-detection by colour in the whole picture: a coarse map of target probabilities and box sums from an
//! integral image.
//!
//! Every few pixels one sample is looked up in the colour model. Candidates are places where a box of the
//! target's size has a higher mean target probability than the ring around it. Each candidate is then refined
//! to the nearby position and the scale with the highest contrast of a box of the target's proportions, since
//! the target may have come nearer or gone farther away. Candidates are found by colour alone; the
//! correlation filter has to confirm them.

use barrelman_vocab::Picture;

use crate::colour_model::ColourModel;
use crate::integral_image::IntegralImage;
use crate::simd::simd_kernel;

/// A place that may show the target.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Candidate {
    /// Centre, pixels.
    pub(crate) centre: (f32, f32),
    /// Mean target probability in the box less that in the ring, -1 to 1.
    pub(crate) contrast: f32,
    /// Similarity of the layout of its colours to the target's, 0 to 1; set by the caller.
    pub(crate) layout_similarity: f32,
    /// Scale with the highest contrast, relative to the expected size.
    pub(crate) scale: f32,
}

#[derive(Debug, Default)]
pub(crate) struct Redetector {
    image: IntegralImage,
    /// Sums between two rows of the integral image, and contrasts, for each column of one row of places.
    inner: Vec<u32>,
    outer: Vec<u32>,
    contrasts: Vec<f32>,
    candidates: Vec<Candidate>,
}

/// Maximum number of candidates.
pub(crate) const MAX_CANDIDATES: usize = 12;

impl Redetector {
    /// Finds the best candidates for a target whose upright box has these sides (pixels), best first.
    pub(crate) fn find_candidates(
        &mut self,
        picture: &Picture,
        model: &ColourModel,
        (w, h): (f32, f32),
    ) -> &[Candidate] {
        let size = (w * h).sqrt();
        // Ten samples a side distinguish a box from its surroundings and from boxes of other sizes. A chroma
        // sample covers two pixels.
        let step = ((size / 20.0) as usize).clamp(1, 16);
        self.candidates.clear();
        self.candidates.reserve(MAX_CANDIDATES);
        self.image.build(picture, model, step);
        let unit = 2.0 * step as f32;
        self.collect(size, unit);
        for index in 0..self.candidates.len() {
            self.candidates[index] = self.refined(self.candidates[index], (w / unit, h / unit), unit);
        }
        &self.candidates
    }

    /// Collects the places where a square of the target's size (pixels) has a higher mean target probability
    /// than the ring around it. A sample covers `unit` pixels.
    fn collect(&mut self, size: f32, unit: f32) {
        let half = ((0.5 * size / unit + 0.5) as usize).max(1);
        let outer = 2 * half;
        let stride = (half / 2).max(1);
        for row in (0..self.image.height).step_by(stride) {
            self.fill_contrasts(row, half, outer);
            if !self.contrasts.iter().any(|&contrast| contrast > MIN_CONTRAST) {
                continue;
            }
            for column in (0..self.image.width).step_by(stride) {
                let contrast = self.contrasts[column];
                if contrast > MIN_CONTRAST {
                    let centre = ((column as f32 + 0.5) * unit, (row as f32 + 0.5) * unit);
                    self.insert(Candidate { centre, contrast, layout_similarity: 0.0, scale: 1.0 }, size);
                }
            }
        }
    }

    /// Fills `contrasts`: for each column the mean target probability in a square of `half` samples to every
    /// side of the place, less that in the ring around it, up to `outer` samples from the place.
    fn fill_contrasts(&mut self, row: usize, half: usize, outer: usize) {
        let image = &self.image;
        self.contrasts.resize(image.width, 0.0);
        // Between these columns no square is cut off at the left or right edge.
        let (first, behind) =
            (outer.min(image.width), image.width.saturating_sub(outer).max(outer.min(image.width)));
        let counted = |half: usize| (row + half + 1).min(image.height) - row.saturating_sub(half);
        for (sums, half) in [(&mut self.inner, half), (&mut self.outer, outer)] {
            let top = row.saturating_sub(half);
            subtract_rows(image.line(top + counted(half)), image.line(top), sums);
        }
        let places = &mut self.contrasts[first..behind];
        let squares = [(half, counted(half)), (outer, counted(outer))];
        row_contrasts(&self.inner[first - half.min(first)..], &self.outer, squares, places);
        for column in (0..first).chain(behind..image.width) {
            let (inner, around) = (image.square_sum(column, row, half), image.square_sum(column, row, outer));
            self.contrasts[column] = contrast(inner, around);
        }
    }

    /// Moves a candidate to the nearby position and scale with the highest contrast. `sides` are in samples.
    fn refined(&self, candidate: Candidate, sides: (f32, f32), unit: f32) -> Candidate {
        let first = ((candidate.centre.0 / unit) as usize, (candidate.centre.1 / unit) as usize);
        let mut best = (first, 1.0_f32, self.contrast_at(first, sides, 1.0));
        for _ in 0..REFINEMENT_ROUNDS {
            let from = best;
            for scale in SCALES {
                let stride = |side: f32| ((REFINEMENT_STEP_SHARE * scale * side) as usize).max(1);
                let (across, down) = (stride(sides.0), stride(sides.1));
                let around = |at: usize, by: usize, length: usize| {
                    [at.saturating_sub(by), at, (at + by).min(length - 1)]
                };
                for row in around(from.0.1, down, self.image.height) {
                    for column in around(from.0.0, across, self.image.width) {
                        let contrast = self.contrast_at((column, row), sides, scale);
                        if contrast > best.2 {
                            best = ((column, row), scale, contrast);
                        }
                    }
                }
            }
            if best == from {
                break;
            }
        }
        let ((column, row), scale, _) = best;
        let centre = ((column as f32 + 0.5) * unit, (row as f32 + 0.5) * unit);
        Candidate { centre, scale, ..candidate }
    }

    /// Mean target probability in a box around a sample less that in the ring around the box.
    fn contrast_at(&self, at: (usize, usize), sides: (f32, f32), scale: f32) -> f32 {
        let half = |side: f32| (0.5 * scale * side).max(0.5) as usize;
        let half = (half(sides.0), half(sides.1));
        let ring = half.0.max(half.1).max(1);
        let (inner, outer) =
            (self.image.box_sum(at, half), self.image.box_sum(at, (half.0 + ring, half.1 + ring)));
        contrast(inner, outer)
    }

    /// Keeps the best candidates; of two nearer to each other than the target's size, the better one.
    fn insert(&mut self, new: Candidate, size: f32) {
        let near = |c: &Candidate| {
            (c.centre.0 - new.centre.0).abs() < size && (c.centre.1 - new.centre.1).abs() < size
        };
        if let Some(old) = self.candidates.iter_mut().find(|c| near(c)) {
            if new.contrast <= old.contrast {
                return;
            }
            *old = new;
        } else if self.candidates.len() < MAX_CANDIDATES {
            self.candidates.push(new);
        } else if let Some(worst) =
            self.candidates.iter_mut().min_by(|a, b| a.contrast.total_cmp(&b.contrast))
        {
            if worst.contrast >= new.contrast {
                return;
            }
            *worst = new;
        }
        self.candidates.sort_by(|a, b| b.contrast.total_cmp(&a.contrast));
    }
}

/// Mean target probability inside less that in the ring around it, from the sum and the number of the samples
/// inside, and those of both together.
#[inline(always)]
fn contrast(inner: (u32, u32), outer: (u32, u32)) -> f32 {
    let mean = |sum: u32, count: u32| sum as f32 / (255 * count) as f32;
    mean(inner.0, inner.1) - mean(outer.0 - inner.0, (outer.1 - inner.1).max(1))
}

simd_kernel! {
/// The difference of two rows of an integral image.
fn subtract_rows(lower: &[u32], upper: &[u32], out: &mut Vec<u32>) {
    out.clear();
    out.extend(lower.iter().zip(upper).map(|(lower, upper)| lower - upper));
}
}

simd_kernel! {
/// The contrasts of consecutive places from the sums of the columns. `squares` gives the half side and the
/// rows of the inner and the outer square, which begin with the first column of `inner` and `outer`.
fn row_contrasts(inner: &[u32], outer: &[u32], squares: [(usize, usize); 2], out: &mut [f32]) {
    let [inner_side, outer_side] = squares.map(|(half, _)| 2 * half + 1);
    let count = |side: usize, (_, rows): (usize, usize)| (side * rows) as u32;
    let (inner_count, outer_count) = (count(inner_side, squares[0]), count(outer_side, squares[1]));
    let places = out.len();
    if places == 0 {
        return;
    }
    let (inner_left, inner_right) = (&inner[..places], &inner[inner_side..][..places]);
    let (outer_left, outer_right) = (&outer[..places], &outer[outer_side..][..places]);
    for i in 0..places {
        let (inner, outer) = (inner_right[i] - inner_left[i], outer_right[i] - outer_left[i]);
        out[i] = contrast((inner, inner_count), (outer, outer_count));
    }
}
}

/// Minimum contrast of a candidate.
const MIN_CONTRAST: f32 = 0.1;
/// Rounds of the refinement.
const REFINEMENT_ROUNDS: usize = 3;
/// Scales of the refinement, relative to the expected size.
const SCALES: [f32; 7] = [0.5, 0.6, 0.71, 0.84, 1.0, 1.19, 1.41];
/// Step of the refinement, in sides of the box.
const REFINEMENT_STEP_SHARE: f32 = 0.2;

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::ColourEncoding;

    use super::*;
    use crate::colour_model::{TargetEllipse, count_colours};
    use crate::test_picture::painted;

    const RED: [u8; 3] = [81, 90, 240];
    const BLUE: [u8; 3] = [70, 190, 100];

    /// A blue picture with red boxes (left, top, width, height).
    fn picture(boats: &[[usize; 4]]) -> Picture {
        painted((320, 240), |column, row| {
            let is_inside = boats.iter().any(|&[left, top, w, h]| {
                (left..left + w).contains(&column) && (top..top + h).contains(&row)
            });
            if is_inside { RED } else { BLUE }
        })
    }

    /// The candidates for a red target of this size.
    fn found(boats: &[[usize; 4]], size: f32) -> Vec<Candidate> {
        let learned = picture(&[[140, 100, 40, 40]]);
        let mut model = ColourModel::default();
        count_colours(
            &learned,
            (160.0, 120.0),
            &TargetEllipse::inscribed_in((40.0, 40.0)),
            &mut model.target,
            &mut model.surroundings,
        );
        model.update_table();
        Redetector::default().find_candidates(&picture(boats), &model, (size, size)).to_vec()
    }

    fn near(candidate: &Candidate, (u, v): (f32, f32), pixels: f32) -> bool {
        (candidate.centre.0 - u).abs() <= pixels && (candidate.centre.1 - v).abs() <= pixels
    }

    #[test]
    fn a_patch_of_the_targets_colour_is_found_wherever_it_lies() {
        for [left, top] in [[0, 0], [280, 0], [0, 200], [280, 200], [37, 91], [200, 120]] {
            let found = found(&[[left, top, 40, 40]], 40.0);
            let middle = (left as f32 + 20.0, top as f32 + 20.0);
            // The box consists of whole samples and exceeds the target: several positions are equally good.
            assert!(near(&found[0], middle, 20.0), "{left},{top}: {found:?}");
            assert!(found[0].contrast > 0.4, "{left},{top}: {found:?}");
        }
    }

    #[test]
    fn the_scale_of_a_candidate_is_found() {
        for side in [24, 40, 56] {
            let found = found(&[[130, 90, side, side]], 40.0);
            let scale = side as f32 / 40.0;
            // Neighbouring scales differ by a factor of 1.19, and a sample is a twentieth of the size.
            assert!((0.8..1.25).contains(&(found[0].scale / scale)), "{side}: {found:?}");
            let middle = (130.0 + side as f32 / 2.0, 90.0 + side as f32 / 2.0);
            assert!(near(&found[0], middle, 5.0), "{side}: {found:?}");
        }
    }

    #[test]
    fn two_boats_give_two_candidates_with_the_better_one_first() {
        let found = found(&[[30, 60, 40, 32], [230, 140, 40, 40]], 40.0);
        assert!(near(&found[0], (250.0, 160.0), 20.0), "{found:?}");
        assert!(near(&found[1], (50.0, 76.0), 20.0), "{found:?}");
        assert!(found[0].contrast > found[1].contrast);
    }

    #[test]
    fn of_many_the_best_few_are_kept() {
        let boats: Vec<_> = (0..15).map(|k| [12 + 62 * (k % 5), 14 + 74 * (k / 5), 40, 12 + 2 * k]).collect();
        let found = found(&boats, 40.0);
        assert_eq!(found.len(), MAX_CANDIDATES);
        assert!(found.iter().any(|candidate| near(candidate, (280.0, 182.0), 20.0)), "{found:?}");
        assert!(found.is_sorted_by(|a, b| a.contrast >= b.contrast));
        assert!(found.iter().all(|candidate| !near(candidate, (32.0, 20.0), 20.0)), "{found:?}");
    }

    #[test]
    fn where_nothing_or_everything_has_its_colour_there_is_no_candidate() {
        assert_eq!(found(&[], 40.0), []);
        assert_eq!(found(&[[0, 0, 320, 240]], 40.0), []);
    }

    #[test]
    fn the_contrasts_of_a_row_are_those_of_its_places() {
        let mut model = ColourModel::default();
        let boats = picture(&[[30, 60, 40, 32], [280, 0, 40, 40]]);
        let ellipse = TargetEllipse::inscribed_in((40.0, 32.0));
        count_colours(&boats, (50.0, 76.0), &ellipse, &mut model.target, &mut model.surroundings);
        model.update_table();
        let mut redetector = Redetector::default();
        for (step, half) in [(1, 1), (1, 20), (2, 9), (3, 30), (3, 200)] {
            redetector.image.build(&boats, &model, step);
            for row in 0..redetector.image.height {
                redetector.fill_contrasts(row, half, 2 * half);
                for (column, &seen) in redetector.contrasts.iter().enumerate() {
                    let inner = redetector.image.square_sum(column, row, half);
                    let expected = contrast(inner, redetector.image.square_sum(column, row, 2 * half));
                    assert_eq!(seen.to_bits(), expected.to_bits(), "{step} {half}: {column},{row}");
                }
            }
        }
    }

    #[test]
    fn pictures_of_any_size_can_be_searched() {
        let mut redetection = Redetector::default();
        for (width, height) in [(0, 0), (0, 9), (1, 1), (2, 2), (3, 1), (1, 70), (33, 31)] {
            let size = PictureSize::new(width, height);
            let picture = Picture::black(size, ColourEncoding::assumed_for(size));
            for target in [0.0, 1.0, 12.0, 5000.0, f32::NAN] {
                assert!(
                    redetection
                        .find_candidates(&picture, &ColourModel::default(), (target, target))
                        .is_empty()
                );
            }
        }
    }
}
