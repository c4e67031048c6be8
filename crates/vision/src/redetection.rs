//! Finding the target again anywhere in the picture: a coarse back projection and boxes summed by an integral image.
//!
//! One sample every few pixels is looked up in the colour model. Candidates are the places where a box of the
//! target's size holds more likeness than the ring around it; they are told by colour alone and are worth no more
//! than a second look.

use barrelman_vocab::Picture;

use crate::colour_model::ColourModel;

/// A place worth a second look.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Candidate {
    /// Middle, pixels.
    pub(crate) centre: (f32, f32),
    /// Mean likeness in the box less that of the ring, -1 to 1.
    pub(crate) contrast: f32,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Redetection {
    /// Sums of likeness over everything above and to the left; one row and column of zeros first.
    sums: Vec<u32>,
    width: usize,
    height: usize,
    candidates: Vec<Candidate>,
}

/// Most candidates kept.
pub(crate) const CANDIDATES: usize = 8;

impl Redetection {
    /// The best candidates of a target of that size (pixels, a side), best first.
    pub(crate) fn look(&mut self, picture: &Picture, model: &ColourModel, size: f32) -> &[Candidate] {
        // Five samples a side tell a box from its surroundings; chroma has one sample in two pixels.
        let step = ((size / 10.0) as usize).clamp(1, 16);
        let (y, u, v) = (picture.y(), picture.u(), picture.v());
        (self.width, self.height) = (u.width / step, u.height / step);
        let stride = self.width + 1;
        self.sums.clear();
        self.sums.resize(stride * (self.height + 1), 0);
        self.candidates.clear();
        if self.width == 0 || self.height == 0 {
            return &self.candidates;
        }
        let table = model.table();
        for row in 0..self.height {
            let (us, vs) = (u.row(row * step + step / 2), v.row(row * step + step / 2));
            let ys = y.row((2 * (row * step + step / 2)).min(y.height - 1));
            let (above, here) = self.sums.split_at_mut((row + 1) * stride);
            let above = &above[row * stride + 1..];
            let mut sum = 0;
            for (column, (out, above)) in here[1..stride].iter_mut().zip(above).enumerate() {
                let x = column * step + step / 2;
                sum += u32::from(table.of(ys[(2 * x).min(y.width - 1)], us[x], vs[x]));
                *out = sum + above;
            }
        }
        let unit = 2.0 * step as f32;
        let half = ((0.5 * size / unit + 0.5) as usize).max(1);
        let outer = 2 * half;
        let stride_of_search = (half / 2).max(1);
        let mut row = 0;
        while row < self.height {
            let mut column = 0;
            while column < self.width {
                let inner = self.sum(column, row, half);
                let around = self.sum(column, row, outer);
                let mean = inner.0 as f32 / (255 * inner.1) as f32;
                let ring = (around.1 - inner.1).max(1);
                let ring_mean = (around.0 - inner.0) as f32 / (255 * ring) as f32;
                let contrast = mean - ring_mean;
                if contrast > 0.1 {
                    self.keep(
                        Candidate {
                            centre: ((column as f32 + 0.5) * unit, (row as f32 + 0.5) * unit),
                            contrast,
                        },
                        size,
                    );
                }
                column += stride_of_search;
            }
            row += stride_of_search;
        }
        &self.candidates
    }

    /// Sum and count of the samples within `half` of one.
    fn sum(&self, column: usize, row: usize, half: usize) -> (u32, u32) {
        let (left, top) = (column.saturating_sub(half), row.saturating_sub(half));
        let (right, bottom) = ((column + half + 1).min(self.width), (row + half + 1).min(self.height));
        let at = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
        let sum = at(right, bottom) + at(left, top) - at(left, bottom) - at(right, top);
        (sum, ((right - left) * (bottom - top)) as u32)
    }

    /// Keeps the best few, of those nearer to each other than the target's size the better one.
    fn keep(&mut self, new: Candidate, size: f32) {
        let near = |c: &Candidate| {
            (c.centre.0 - new.centre.0).abs() < size && (c.centre.1 - new.centre.1).abs() < size
        };
        if let Some(old) = self.candidates.iter_mut().find(|c| near(c)) {
            if new.contrast > old.contrast {
                *old = new;
            }
        } else if self.candidates.len() < CANDIDATES {
            self.candidates.push(new);
        } else if let Some(worst) =
            self.candidates.iter_mut().min_by(|a, b| a.contrast.total_cmp(&b.contrast))
            && worst.contrast < new.contrast
        {
            *worst = new;
        }
        self.candidates.sort_by(|a, b| b.contrast.total_cmp(&a.contrast));
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::ColourEncoding;

    use super::*;
    use crate::colour_model::count_colours;

    const RED: [u8; 3] = [81, 90, 240];
    const BLUE: [u8; 3] = [70, 190, 100];

    /// A blue picture with red boxes (left, top, width, height).
    fn picture(boats: &[[usize; 4]]) -> Picture {
        let size = PictureSize::new(320, 240);
        let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
        for (plane, (samples, step)) in picture.planes_mut().into_iter().zip([1, 2, 2]).enumerate() {
            let width = 320 / step;
            for (index, sample) in samples.iter_mut().enumerate() {
                let (column, row) = (index % width * step, index / width * step);
                let inside = boats.iter().any(|&[left, top, w, h]| {
                    (left..left + w).contains(&column) && (top..top + h).contains(&row)
                });
                *sample = if inside { RED[plane] } else { BLUE[plane] };
            }
        }
        picture
    }

    /// What is found of a red target of that size.
    fn found(boats: &[[usize; 4]], size: f32) -> Vec<Candidate> {
        let learned = picture(&[[140, 100, 40, 40]]);
        let mut model = ColourModel::default();
        count_colours(&learned, (160.0, 120.0), (40.0, 40.0), &mut model.target, &mut model.surroundings);
        model.renew();
        Redetection::default().look(&picture(boats), &model, size).to_vec()
    }

    fn near(candidate: &Candidate, (u, v): (f32, f32), pixels: f32) -> bool {
        (candidate.centre.0 - u).abs() <= pixels && (candidate.centre.1 - v).abs() <= pixels
    }

    #[test]
    fn a_patch_of_the_targets_colour_is_found_wherever_it_lies() {
        for [left, top] in [[0, 0], [280, 0], [0, 200], [280, 200], [37, 91], [200, 120]] {
            let found = found(&[[left, top, 40, 40]], 40.0);
            let middle = (left as f32 + 20.0, top as f32 + 20.0);
            // The box is of whole samples and larger than the target: several places are as good.
            assert!(near(&found[0], middle, 20.0), "{left},{top}: {found:?}");
            assert!(found[0].contrast > 0.4, "{left},{top}: {found:?}");
        }
    }

    #[test]
    fn two_that_are_apart_are_told_apart_and_the_better_one_comes_first() {
        let found = found(&[[30, 60, 40, 32], [230, 140, 40, 40]], 40.0);
        assert!(near(&found[0], (250.0, 160.0), 20.0), "{found:?}");
        assert!(near(&found[1], (50.0, 76.0), 20.0), "{found:?}");
        assert!(found[0].contrast > found[1].contrast);
    }

    #[test]
    fn of_many_the_best_few_are_kept() {
        let boats: Vec<_> =
            (0..10).map(|k| [12 + 62 * (k % 5), 40 + 110 * (k / 5), 40, 13 + 3 * k]).collect();
        let found = found(&boats, 40.0);
        assert_eq!(found.len(), CANDIDATES);
        assert!(found.iter().any(|candidate| near(candidate, (280.0, 170.0), 20.0)), "{found:?}");
        assert!(found.is_sorted_by(|a, b| a.contrast >= b.contrast));
        assert!(found.iter().all(|candidate| !near(candidate, (32.0, 46.5), 20.0)), "{found:?}");
    }

    #[test]
    fn where_nothing_or_everything_has_its_colour_there_is_no_candidate() {
        assert_eq!(found(&[], 40.0), []);
        assert_eq!(found(&[[0, 0, 320, 240]], 40.0), []);
    }

    #[test]
    fn pictures_of_any_size_can_be_looked_at() {
        let mut redetection = Redetection::default();
        for (width, height) in [(0, 0), (0, 9), (1, 1), (2, 2), (3, 1), (1, 70), (33, 31)] {
            let size = PictureSize::new(width, height);
            let picture = Picture::black(size, ColourEncoding::assumed_for(size));
            for target in [0.0, 1.0, 12.0, 5000.0, f32::NAN] {
                assert!(redetection.look(&picture, &ColourModel::default(), target).is_empty());
            }
        }
    }
}
