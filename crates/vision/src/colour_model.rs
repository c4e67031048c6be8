//! Probability that a colour belongs to the target rather than to its surroundings.
//!
//! Two histograms over (Y, U, V), one of the target (F) and one of the ring around it (B), are each
//! normalised to a sum of 1. The target probability of a colour is
//!
//! ```text
//! F / (F + B + e)
//! ```
//!
//! with a small e, so that a colour seen in neither is not the target's. U and V are hue and saturation in
//! Cartesian coordinates: there is no wrap-around of the hue, and grey needs no floors. It is a bin like any
//! other.

use crate::vector::Rotation;
use barrelman_vocab::Picture;

/// Bits of Y.
const LUMA_BITS: u32 = 3;
/// Bits of U and of V.
const CHROMA_BITS: u32 = 5;
const LUMA: usize = 1 << LUMA_BITS;
const CHROMA: usize = 1 << CHROMA_BITS;
/// Added to a frequency before its logarithm is taken.
const LEAST_FREQUENCY: f32 = 1.0e-5;
/// Share of the selection's colours in the target's.
const SELECTED_SHARE: f32 = 0.5;
/// Number of bins.
pub(crate) const BINS: usize = LUMA * CHROMA * CHROMA;

/// A histogram of colours.
#[derive(Debug, Clone)]
pub(crate) struct ColourHistogram {
    bins: Vec<f32>,
}

impl Default for ColourHistogram {
    fn default() -> Self {
        Self { bins: vec![0.0; BINS] }
    }
}

/// The bin of a colour. The chroma of video is concentrated around 128; only 64 to 192 is resolved.
pub(crate) fn bin(y: u8, u: u8, v: u8) -> usize {
    let chroma = |c: u8| usize::from(c.saturating_sub(64).min(127)) >> (7 - CHROMA_BITS);
    let luma = usize::from(y) >> (8 - LUMA_BITS);
    (luma * CHROMA + chroma(u)) * CHROMA + chroma(v)
}

impl ColourHistogram {
    pub(crate) fn clear(&mut self) {
        self.bins.fill(0.0);
    }

    pub(crate) fn add(&mut self, bin: usize, weight: f32) {
        self.bins[bin % BINS] += weight;
    }

    /// Smooths the counts over neighbouring bins in U, V and Y, and scales the sum to 1.
    pub(crate) fn smooth_and_normalise(&mut self) {
        smooth(&mut self.bins, 1, CHROMA);
        smooth(&mut self.bins, CHROMA, CHROMA);
        smooth(&mut self.bins, CHROMA * CHROMA, LUMA);
        let sum: f32 = self.bins.iter().sum();
        if sum > 0.0 {
            let scale = 1.0 / sum;
            self.bins.iter_mut().for_each(|bin| *bin *= scale);
        }
    }

    /// Similarity of two normalised histograms, 0 to 1: the Bhattacharyya coefficient, the sum of the roots
    /// of the products (Bhattacharyya 1943).
    pub(crate) fn similarity(&self, other: &Self) -> f32 {
        self.bins.iter().zip(&other.bins).map(|(a, b)| (a * b).sqrt()).sum()
    }

    /// Mean logarithm of the frequency in another histogram of the colours in this one, both normalised.
    pub(crate) fn mean_logarithm_in(&self, other: &Self) -> f32 {
        let bins = self.bins.iter().zip(&other.bins).filter(|(here, _)| **here > 0.0);
        bins.map(|(here, there)| here * libm::logf(there + LEAST_FREQUENCY)).sum()
    }

    /// Makes this histogram equal to another, without allocation.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.bins.copy_from_slice(&other.bins);
    }

    /// Moves this histogram towards another by the share `rate`.
    pub(crate) fn blend(&mut self, other: &Self, rate: f32) {
        for (bin, &new) in self.bins.iter_mut().zip(&other.bins) {
            *bin += rate * (new - *bin);
        }
    }
}

/// Filters along one dimension of the histogram with (1 2 1) / 4; border bins are replicated.
pub(crate) fn smooth(bins: &mut [f32], stride: usize, length: usize) {
    for block in bins.chunks_exact_mut(stride * length) {
        for offset in 0..stride {
            let mut before = block[offset];
            for k in 0..length {
                let here = block[k * stride + offset];
                let after = if k + 1 < length { block[(k + 1) * stride + offset] } else { here };
                block[k * stride + offset] = 0.25 * before + 0.5 * here + 0.25 * after;
                before = here;
            }
        }
    }
}

/// The two histograms and the table of probabilities computed from them.
#[derive(Debug, Clone, Default)]
pub(crate) struct ColourModel {
    /// The colours that the target is recognised by: a mixture of those at the selection and the adapted
    /// ones.
    pub(crate) target: ColourHistogram,
    selected: ColourHistogram,
    adapted: ColourHistogram,
    pub(crate) surroundings: ColourHistogram,
    table: TargetProbabilities,
}

/// Target probability of each bin, 0 to 255.
#[derive(Debug, Clone)]
pub(crate) struct TargetProbabilities(Vec<u8>);

impl Default for TargetProbabilities {
    fn default() -> Self {
        Self(vec![0; BINS])
    }
}

impl TargetProbabilities {
    /// Target probability of a colour, 0 to 255.
    pub(crate) fn probability(&self, y: u8, u: u8, v: u8) -> u8 {
        self.0[bin(y, u, v)]
    }

    /// Target probability of the colours of a bin, 0 to 255.
    pub(crate) fn of_bin(&self, bin: u16) -> u8 {
        self.0[usize::from(bin)]
    }
}

impl ColourModel {
    /// Computes the table from the histograms.
    pub(crate) fn update_table(&mut self) {
        // A colour less frequent than this in both histograms counts as unknown.
        const PRIOR_MASS: f32 = 2.0e-4;
        for ((table, &f), &b) in self.table.0.iter_mut().zip(&self.target.bins).zip(&self.surroundings.bins) {
            *table = (255.0 * f / (f + b + PRIOR_MASS) + 0.5) as u8;
        }
    }

    pub(crate) fn table(&self) -> &TargetProbabilities {
        &self.table
    }

    /// Makes the present colours of the target those of the selection.
    pub(crate) fn remember_selection(&mut self) {
        self.selected.copy_from(&self.target);
        self.adapted.copy_from(&self.target);
    }

    /// Adapts to the colours of a frame, of the target at this rate and of its surroundings at twice the
    /// rate: the water changes faster than the target's paint. The colours of the selection keep their share.
    pub(crate) fn adapt(&mut self, target: &ColourHistogram, surroundings: &ColourHistogram, rate: f32) {
        self.adapted.blend(target, rate);
        self.target.copy_from(&self.adapted);
        self.target.blend(&self.selected, SELECTED_SHARE);
        self.surroundings.blend(surroundings, 2.0 * rate);
        self.update_table();
    }
}

/// The target's ellipse, and the upright box around which the ring begins.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TargetEllipse {
    /// Width and height of the upright box, pixels.
    pub(crate) box_size: (f32, f32),
    /// Half axes of the ellipse, pixels.
    pub(crate) half: (f32, f32),
    /// Direction of the first half axis, radians clockwise from image right.
    pub(crate) angle: f32,
}

impl TargetEllipse {
    /// The ellipse inscribed in an upright box, pixels.
    pub(crate) fn inscribed_in((w, h): (f32, f32)) -> Self {
        Self { box_size: (w, h), half: (0.5 * w, 0.5 * h), angle: 0.0 }
    }
}

/// Counts the colours inside the ellipse (weights decrease from the centre to the edge) and in the ring
/// around its box, and normalises both histograms.
pub(crate) fn count_colours(
    picture: &Picture,
    centre: (f32, f32),
    region: &TargetEllipse,
    inside: &mut ColourHistogram,
    around: &mut ColourHistogram,
) {
    let (w, h) = region.box_size;
    let turn = Rotation::by(region.angle);
    inside.clear();
    around.clear();
    let (y, u, v) = (picture.y(), picture.u(), picture.v());
    if u.width == 0 || u.height == 0 {
        return;
    }
    let margin = RING_WIDTH_SIDES * 0.5 * (w + h);
    // In samples of the chroma planes; a cast turns negative numbers into 0.
    let sample_range = |middle: f32, half: f32, length: usize| {
        (((middle - half) / 2.0) as usize).min(length)..(((middle + half) / 2.0) as usize + 1).min(length)
    };
    let rows = sample_range(centre.1, 0.5 * h + margin, u.height);
    let columns = sample_range(centre.0, 0.5 * w + margin, u.width);
    // Large targets are subsampled, to bound the work.
    let stride = (((rows.len() * columns.len()) as f32 / MAX_SAMPLES).sqrt().ceil() as usize).max(1);
    for row in rows.step_by(stride) {
        let (ys, us, vs) = (y.row((2 * row).min(y.height - 1)), u.row(row), v.row(row));
        for column in columns.clone().step_by(stride) {
            let bin = bin(ys[(2 * column).min(y.width - 1)], us[column], vs[column]);
            let (right, down) = (2.0 * column as f32 + 1.0 - centre.0, 2.0 * row as f32 + 1.0 - centre.1);
            let (forward, aside) = turn.undo((right, down));
            let (along, across) = (forward / region.half.0, aside / region.half.1);
            let radius_squared = along * along + across * across;
            if radius_squared < 1.0 {
                inside.add(bin, 1.0 - 0.7 * radius_squared);
            } else if 2.0 * right.abs() > RING_INNER_SIDES * w || 2.0 * down.abs() > RING_INNER_SIDES * h {
                around.add(bin, 1.0);
            }
        }
    }
    inside.smooth_and_normalise();
    around.smooth_and_normalise();
}

/// Counts the colours of the whole picture, and normalises the histogram.
pub(crate) fn count_picture(picture: &Picture, out: &mut ColourHistogram) {
    out.clear();
    let (y, u, v) = (picture.y(), picture.u(), picture.v());
    let stride = (((u.width * u.height) as f32 / MAX_SAMPLES).sqrt().ceil() as usize).max(1);
    for row in (0..u.height).step_by(stride) {
        let (ys, us, vs) = (y.row((2 * row).min(y.height - 1)), u.row(row), v.row(row));
        for column in (0..u.width).step_by(stride) {
            out.add(bin(ys[(2 * column).min(y.width - 1)], us[column], vs[column]), 1.0);
        }
    }
    out.smooth_and_normalise();
}

/// Inner size of the ring, in sides of the box.
const RING_INNER_SIDES: f32 = 1.1;
/// Width of the ring, in mean sides of the box.
const RING_WIDTH_SIDES: f32 = 0.7;
/// Maximum number of samples that are counted.
const MAX_SAMPLES: f32 = 4096.0;

#[cfg(test)]
mod tests {
    use core::f32::consts::{FRAC_PI_4, SQRT_2};

    use super::*;
    use crate::test_picture::painted;

    const RED: [u8; 3] = [81, 90, 240];
    const BLUE: [u8; 3] = [70, 190, 100];
    const GREY: [u8; 3] = [120, 128, 128];

    /// A picture of one colour with a box (left, top, width, height) of another.
    fn picture(water: [u8; 3], boat: [u8; 3], [left, top, w, h]: [usize; 4]) -> Picture {
        painted((120, 90), |column, row| {
            let is_inside = (left..left + w).contains(&column) && (top..top + h).contains(&row);
            if is_inside { boat } else { water }
        })
    }

    fn learned(picture: &Picture, centre: (f32, f32), size: (f32, f32)) -> ColourModel {
        let mut model = ColourModel::default();
        count_colours(
            picture,
            centre,
            &TargetEllipse::inscribed_in(size),
            &mut model.target,
            &mut model.surroundings,
        );
        model.update_table();
        model
    }

    fn probability(model: &ColourModel, [y, u, v]: [u8; 3]) -> u8 {
        model.table().probability(y, u, v)
    }

    fn sum(histogram: &ColourHistogram) -> f32 {
        histogram.bins.iter().sum()
    }

    #[test]
    fn a_colour_of_the_target_alone_is_likely_and_others_are_not() {
        let model = learned(&picture(BLUE, RED, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!(probability(&model, RED) > 250, "{}", probability(&model, RED));
        assert_eq!(probability(&model, BLUE), 0);
        // Seen in neither: an unknown colour is not the target's.
        assert_eq!(probability(&model, [200, 90, 90]), 0);
    }

    #[test]
    fn the_colours_of_the_selection_keep_their_share() {
        let mut model = learned(&picture(BLUE, RED, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        model.remember_selection();
        let other = learned(&picture(BLUE, GREY, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        for _ in 0..500 {
            model.adapt(&other.target, &other.surroundings, 0.05);
        }
        assert!(probability(&model, RED) > 250, "{}", probability(&model, RED));
        assert!(probability(&model, GREY) > 250, "{}", probability(&model, GREY));
        assert!((sum(&model.target) - 1.0).abs() < 1e-3);
        assert!((model.target.similarity(&other.target) - SELECTED_SHARE.sqrt()).abs() < 0.05);
    }

    #[test]
    fn a_colour_that_is_as_common_around_the_target_as_in_it_says_nothing() {
        let model = learned(&picture(RED, RED, [0, 0, 1, 1]), (60.0, 45.0), (40.0, 30.0));
        assert!((125..=128).contains(&probability(&model, RED)), "{}", probability(&model, RED));
    }

    #[test]
    fn the_water_in_the_box_of_a_hull_that_lies_askew_is_not_its_colour() {
        // A hull four times as long as wide, at 45 degrees.
        let picture = painted((120, 90), |column, row| {
            let (right, down) = (column as f32 - 60.0, row as f32 - 45.0);
            let (along, across) = ((right + down) / SQRT_2, (down - right) / SQRT_2);
            if along * along / (32.0 * 32.0) + across * across / (8.0 * 8.0) < 1.0 { RED } else { BLUE }
        });
        let box_size = (47.0, 47.0);
        let loose = learned(&picture, (60.0, 45.0), box_size);
        assert!(probability(&loose, BLUE) > 60, "{}", probability(&loose, BLUE));
        let mut close = ColourModel::default();
        let region = TargetEllipse { box_size, half: (32.0, 8.0), angle: FRAC_PI_4 };
        count_colours(&picture, (60.0, 45.0), &region, &mut close.target, &mut close.surroundings);
        close.update_table();
        assert!(probability(&close, BLUE) < 30, "{}", probability(&close, BLUE));
        assert!(probability(&close, RED) > 230, "{}", probability(&close, RED));
    }

    #[test]
    fn grey_is_a_colour_like_any_other() {
        let model = learned(&picture(BLUE, GREY, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!(probability(&model, GREY) > 250, "{}", probability(&model, GREY));
    }

    #[test]
    fn brightness_tells_two_things_of_one_hue_apart() {
        let pale = [230, GREY[1], GREY[2]];
        let model = learned(&picture(GREY, pale, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!(probability(&model, pale) > 250);
        assert_eq!(probability(&model, GREY), 0);
    }

    #[test]
    fn both_histograms_sum_to_one_and_an_empty_one_to_none() {
        let model = learned(&picture(BLUE, RED, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!((sum(&model.target) - 1.0).abs() < 1e-5 && (sum(&model.surroundings) - 1.0).abs() < 1e-5);
        // No ring around a box that fills the picture.
        let model = learned(&picture(BLUE, RED, [0, 0, 120, 90]), (60.0, 45.0), (120.0, 90.0));
        assert!((sum(&model.target) - 1.0).abs() < 1e-5);
        assert_eq!(probability(&model, RED), 255);
    }

    #[test]
    fn similarity_is_one_with_itself_and_none_with_another_colour() {
        let red = learned(&picture(BLUE, RED, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!((red.target.similarity(&red.target) - 1.0).abs() < 1e-5);
        assert_eq!(red.target.similarity(&red.surroundings), 0.0);
        let mut both = red.target.clone();
        both.blend(&red.surroundings, 0.25);
        assert!((both.similarity(&red.target) - 0.75_f32.sqrt()).abs() < 1e-5);
        assert!((sum(&both) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn every_colour_has_a_bin() {
        for level in 0..=255 {
            assert!(bin(level, 255 - level, level / 2) < BINS);
            assert_eq!(bin(level, 0, 255), bin(level, 64, 192), "chroma is resolved from 64 to 192 only");
        }
        assert_eq!(bin(0, 0, 0), 0);
        assert_eq!(bin(255, 255, 255), BINS - 1);
    }
}
