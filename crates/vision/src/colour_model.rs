//! How likely a colour is the target's rather than its surroundings'.
//!
//! Two histograms over (Y, U, V), one of the target (F) and one of the ring around it (B), each normalised to 1.
//! The probability of a colour is F / (F + B) with a small floor that keeps what was seen in neither at one half
//! times a little: unknown is not target. The plane of U and V is the plane of hue and saturation in Cartesian
//! coordinates, so there is no seam in the circle of hues and no hue of grey to be kept out by floors: greys are a
//! bin like any other, and count as much as the target's surroundings leave them.

use barrelman_vocab::Picture;

/// Levels of Y.
const LUMA_BITS: u32 = 3;
/// Levels of U and V.
const CHROMA_BITS: u32 = 5;
const LUMA: usize = 1 << LUMA_BITS;
const CHROMA: usize = 1 << CHROMA_BITS;
/// Bins in all.
pub(crate) const BINS: usize = LUMA * CHROMA * CHROMA;

/// Counts of colours.
#[derive(Debug, Clone)]
pub(crate) struct Histogram {
    bins: Vec<f32>,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { bins: vec![0.0; BINS] }
    }
}

/// The bin of a colour. Chroma of video is concentrated around 128: of its range only 64 to 192 is resolved.
pub(crate) fn bin(y: u8, u: u8, v: u8) -> usize {
    let chroma = |c: u8| usize::from(c.saturating_sub(64).min(127)) >> (7 - CHROMA_BITS);
    let luma = usize::from(y) >> (8 - LUMA_BITS);
    (luma * CHROMA + chroma(u)) * CHROMA + chroma(v)
}

impl Histogram {
    pub(crate) fn clear(&mut self) {
        self.bins.fill(0.0);
    }

    pub(crate) fn add(&mut self, bin: usize, weight: f32) {
        self.bins[bin % BINS] += weight;
    }

    /// Spreads each count a little over its neighbours in U, V and Y, and scales the sum to 1.
    pub(crate) fn finish(&mut self) {
        smooth(&mut self.bins, 1, CHROMA);
        smooth(&mut self.bins, CHROMA, CHROMA);
        smooth(&mut self.bins, CHROMA * CHROMA, LUMA);
        let sum: f32 = self.bins.iter().sum();
        if sum > 0.0 {
            let scale = 1.0 / sum;
            self.bins.iter_mut().for_each(|bin| *bin *= scale);
        }
    }

    /// How alike two are, 0 to 1: the sum of the roots of products (Bhattacharyya 1943).
    pub(crate) fn overlap(&self, other: &Self) -> f32 {
        self.bins.iter().zip(&other.bins).map(|(a, b)| (a * b).sqrt()).sum()
    }

    /// Moves towards another one by the share `rate`.
    pub(crate) fn blend(&mut self, other: &Self, rate: f32) {
        for (bin, &new) in self.bins.iter_mut().zip(&other.bins) {
            *bin += rate * (new - *bin);
        }
    }
}

/// A (1 2 1) / 4 filter along one side of the histogram; what falls off an end stays in it.
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

/// The two histograms and the table that follows from them.
#[derive(Debug, Clone, Default)]
pub(crate) struct ColourModel {
    pub(crate) target: Histogram,
    pub(crate) surroundings: Histogram,
    table: Likenesses,
}

/// Probability of each bin, 0 to 255.
#[derive(Debug, Clone)]
pub(crate) struct Likenesses(Vec<u8>);

impl Default for Likenesses {
    fn default() -> Self {
        Self(vec![0; BINS])
    }
}

impl Likenesses {
    /// Of a colour.
    pub(crate) fn of(&self, y: u8, u: u8, v: u8) -> u8 {
        self.0[bin(y, u, v)]
    }
}

impl ColourModel {
    /// Works the table out again.
    pub(crate) fn renew(&mut self) {
        // A colour rarer than one in some thousands in both is as good as unknown.
        const UNSEEN: f32 = 2.0e-4;
        for ((table, &f), &b) in self.table.0.iter_mut().zip(&self.target.bins).zip(&self.surroundings.bins) {
            *table = (255.0 * f / (f + b + UNSEEN) + 0.5) as u8;
        }
    }

    pub(crate) fn table(&self) -> &Likenesses {
        &self.table
    }
}

/// An ellipse, and the upright box that the ring around it begins at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Region {
    /// Width and height of the box, pixels.
    pub(crate) upright: (f32, f32),
    /// Half axes of the ellipse, pixels.
    pub(crate) half: (f32, f32),
    /// Radians clockwise from image right to the first of them.
    pub(crate) angle: f32,
}

impl Region {
    /// The ellipse in an upright box.
    pub(crate) fn upright((w, h): (f32, f32)) -> Self {
        Self { upright: (w, h), half: (0.5 * w, 0.5 * h), angle: 0.0 }
    }
}

/// Counts the colours within the ellipse (its middle counts more than its edge) and in the ring around the box that is
/// as wide as [`RING_SHARE`] of the box's mean side.
pub(crate) fn count_colours(
    picture: &Picture,
    centre: (f32, f32),
    region: &Region,
    inside: &mut Histogram,
    around: &mut Histogram,
) {
    let (w, h) = region.upright;
    let (cos, sin) = (libm::cosf(region.angle), libm::sinf(region.angle));
    inside.clear();
    around.clear();
    let (y, u, v) = (picture.y(), picture.u(), picture.v());
    if u.width == 0 || u.height == 0 {
        return;
    }
    let margin = RING_SHARE * 0.5 * (w + h);
    // In samples of the chroma planes; a cast takes what is below 0 to 0.
    let span = |middle: f32, half: f32, length: usize| {
        (((middle - half) / 2.0) as usize).min(length)..(((middle + half) / 2.0) as usize + 1).min(length)
    };
    let rows = span(centre.1, 0.5 * h + margin, u.height);
    let columns = span(centre.0, 0.5 * w + margin, u.width);
    // Large targets are sampled: it bounds the work.
    let stride = (((rows.len() * columns.len()) as f32 / MOST_SAMPLES).sqrt().ceil() as usize).max(1);
    for row in rows.step_by(stride) {
        let (ys, us, vs) = (y.row((2 * row).min(y.height - 1)), u.row(row), v.row(row));
        for column in columns.clone().step_by(stride) {
            let bin = bin(ys[(2 * column).min(y.width - 1)], us[column], vs[column]);
            let (right, down) = (2.0 * column as f32 + 1.0 - centre.0, 2.0 * row as f32 + 1.0 - centre.1);
            let (ahead, aside) =
                ((right * cos + down * sin) / region.half.0, (down * cos - right * sin) / region.half.1);
            let off = ahead * ahead + aside * aside;
            if off < 1.0 {
                inside.add(bin, 1.0 - 0.7 * off);
            } else if 2.0 * right.abs() > RING_FROM * w || 2.0 * down.abs() > RING_FROM * h {
                around.add(bin, 1.0);
            }
        }
    }
    inside.finish();
    around.finish();
}

/// Where the ring begins, in sides of the box, ...
const RING_FROM: f32 = 1.1;
/// ... and its width, in mean sides of the box.
const RING_SHARE: f32 = 0.7;
/// Most samples that are counted.
const MOST_SAMPLES: f32 = 4096.0;

#[cfg(test)]
mod tests {
    use core::f32::consts::{FRAC_PI_4, SQRT_2};

    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::ColourEncoding;

    use super::*;

    const RED: [u8; 3] = [81, 90, 240];
    const BLUE: [u8; 3] = [70, 190, 100];
    const GREY: [u8; 3] = [120, 128, 128];

    /// A picture of one colour with a box (left, top, width, height) of another.
    fn picture(water: [u8; 3], boat: [u8; 3], [left, top, w, h]: [usize; 4]) -> Picture {
        let size = PictureSize::new(120, 90);
        let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
        for (plane, (samples, step)) in picture.planes_mut().into_iter().zip([1, 2, 2]).enumerate() {
            let width = 120 / step;
            for (index, sample) in samples.iter_mut().enumerate() {
                let (column, row) = (index % width * step, index / width * step);
                let inside = (left..left + w).contains(&column) && (top..top + h).contains(&row);
                *sample = if inside { boat[plane] } else { water[plane] };
            }
        }
        picture
    }

    fn learned(picture: &Picture, centre: (f32, f32), size: (f32, f32)) -> ColourModel {
        let mut model = ColourModel::default();
        count_colours(picture, centre, &Region::upright(size), &mut model.target, &mut model.surroundings);
        model.renew();
        model
    }

    fn of(model: &ColourModel, [y, u, v]: [u8; 3]) -> u8 {
        model.table().of(y, u, v)
    }

    fn sum(histogram: &Histogram) -> f32 {
        histogram.bins.iter().sum()
    }

    #[test]
    fn a_colour_of_the_target_alone_is_likely_and_others_are_not() {
        let model = learned(&picture(BLUE, RED, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!(of(&model, RED) > 250, "{}", of(&model, RED));
        assert_eq!(of(&model, BLUE), 0);
        // Seen in neither: unknown is not target.
        assert_eq!(of(&model, [200, 90, 90]), 0);
    }

    #[test]
    fn a_colour_that_is_as_common_around_the_target_as_in_it_says_nothing() {
        let model = learned(&picture(RED, RED, [0, 0, 1, 1]), (60.0, 45.0), (40.0, 30.0));
        assert!((125..=128).contains(&of(&model, RED)), "{}", of(&model, RED));
    }

    #[test]
    fn the_water_in_the_box_of_a_hull_that_lies_askew_is_not_its_colour() {
        // A hull four times as long as wide, at 45 degrees.
        let mut picture = picture(BLUE, BLUE, [0, 0, 1, 1]);
        for (plane, (samples, step)) in picture.planes_mut().into_iter().zip([1, 2, 2]).enumerate() {
            let width = 120 / step;
            for (index, sample) in samples.iter_mut().enumerate() {
                let (right, down) =
                    ((index % width * step) as f32 - 60.0, (index / width * step) as f32 - 45.0);
                let (ahead, aside) = ((right + down) / SQRT_2, (down - right) / SQRT_2);
                if (ahead / 32.0).powi(2) + (aside / 8.0).powi(2) < 1.0 {
                    *sample = RED[plane];
                }
            }
        }
        let upright = (47.0, 47.0);
        let loose = learned(&picture, (60.0, 45.0), upright);
        assert!(of(&loose, BLUE) > 60, "{}", of(&loose, BLUE));
        let mut close = ColourModel::default();
        let region = Region { upright, half: (32.0, 8.0), angle: FRAC_PI_4 };
        count_colours(&picture, (60.0, 45.0), &region, &mut close.target, &mut close.surroundings);
        close.renew();
        assert!(of(&close, BLUE) < 30, "{}", of(&close, BLUE));
        assert!(of(&close, RED) > 230, "{}", of(&close, RED));
    }

    #[test]
    fn grey_is_a_colour_like_any_other() {
        let model = learned(&picture(BLUE, GREY, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!(of(&model, GREY) > 250, "{}", of(&model, GREY));
    }

    #[test]
    fn brightness_tells_two_things_of_one_hue_apart() {
        let pale = [230, GREY[1], GREY[2]];
        let model = learned(&picture(GREY, pale, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!(of(&model, pale) > 250);
        assert_eq!(of(&model, GREY), 0);
    }

    #[test]
    fn both_histograms_sum_to_one_and_an_empty_one_to_none() {
        let model = learned(&picture(BLUE, RED, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!((sum(&model.target) - 1.0).abs() < 1e-5 && (sum(&model.surroundings) - 1.0).abs() < 1e-5);
        // Around a box that fills the picture there is nothing.
        let model = learned(&picture(BLUE, RED, [0, 0, 120, 90]), (60.0, 45.0), (120.0, 90.0));
        assert!((sum(&model.target) - 1.0).abs() < 1e-5);
        assert_eq!(of(&model, RED), 255);
    }

    #[test]
    fn overlap_is_one_with_itself_and_none_with_another_colour() {
        let red = learned(&picture(BLUE, RED, [40, 30, 40, 30]), (60.0, 45.0), (40.0, 30.0));
        assert!((red.target.overlap(&red.target) - 1.0).abs() < 1e-5);
        assert_eq!(red.target.overlap(&red.surroundings), 0.0);
        let mut both = red.target.clone();
        both.blend(&red.surroundings, 0.25);
        assert!((both.overlap(&red.target) - 0.75_f32.sqrt()).abs() < 1e-5);
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
