//! Layout of the target's colours: a histogram for each third of its length.
//!
//! Two objects may have the same colours in the same shares and still look different: a boat with a dark
//! engine at the stern, and a raft of the same paint with a dark patch in the middle. The target's ellipse is
//! cut across its axis into [`PARTS`] parts. Each part is compared with the learned one by the Bhattacharyya
//! coefficient. The histograms are coarse and smoothed, because a third of a small target has few samples.
//! The share of a part outside the picture has similarity 0.

use barrelman_vocab::Picture;

use crate::colour_model::smooth;
use crate::vector::{Rotation, length};

/// Number of parts along the axis.
pub(crate) const PARTS: usize = 3;
/// Levels of each of Y, U and V.
const LEVELS: usize = 8;
const BINS: usize = LEVELS * LEVELS * LEVELS;
/// Maximum number of samples that are counted.
const MAX_SAMPLES: f32 = 1024.0;

/// Share of the ellipse's area in each part.
const PART_AREA_SHARES: [f32; PARTS] = [0.292, 0.416, 0.292];

/// Share of its expected samples from which on a part counts as complete: the number of samples depends on
/// how the part lies between them.
const MIN_WHOLE_SHARE: f32 = 0.9;

/// Histogram of each part, with the sum 1 or the share of the part inside the picture.
#[derive(Debug, Clone)]
pub(crate) struct ColourLayout {
    parts: [Vec<f32>; PARTS],
}

impl Default for ColourLayout {
    fn default() -> Self {
        Self { parts: core::array::from_fn(|_| vec![0.0; BINS]) }
    }
}

/// The bin of a colour. The chroma of video is concentrated around 128; only 64 to 192 is resolved.
fn bin(y: u8, u: u8, v: u8) -> usize {
    let chroma = |c: u8| usize::from(c.saturating_sub(64).min(127)) * LEVELS / 128;
    (usize::from(y) * LEVELS / 256 * LEVELS + chroma(u)) * LEVELS + chroma(v)
}

impl ColourLayout {
    /// Counts the colours inside an ellipse of half axes `half` around `centre`, pixels. `angle` turns the
    /// first half axis clockwise, radians.
    pub(crate) fn count(&mut self, picture: &Picture, centre: (f32, f32), half: (f32, f32), angle: f32) {
        self.parts.iter_mut().for_each(|part| part.fill(0.0));
        let (y, u, v) = (picture.y(), picture.u(), picture.v());
        if u.width == 0 || u.height == 0 {
            return;
        }
        let turn = Rotation::by(angle);
        let Rotation { cos, sin } = turn;
        let reach = (length((half.0 * cos, half.1 * sin)), length((half.0 * sin, half.1 * cos)));
        // In samples of the chroma planes; a cast turns negative numbers into 0.
        let sample_range = |middle: f32, half: f32, length: usize| {
            (((middle - half) / 2.0) as usize).min(length)..(((middle + half) / 2.0) as usize + 1).min(length)
        };
        let (rows, columns) =
            (sample_range(centre.1, reach.1, u.height), sample_range(centre.0, reach.0, u.width));
        let stride = (((rows.len() * columns.len()) as f32 / MAX_SAMPLES).sqrt().ceil() as usize).max(1);
        for row in rows.step_by(stride) {
            let (ys, us, vs) = (y.row((2 * row).min(y.height - 1)), u.row(row), v.row(row));
            for column in columns.clone().step_by(stride) {
                let (right, down) = (2.0 * column as f32 + 1.0 - centre.0, 2.0 * row as f32 + 1.0 - centre.1);
                let (forward, aside) = turn.undo((right, down));
                let (along, across) = (forward / half.0, aside / half.1);
                if along * along + across * across < 1.0 {
                    let part = ((0.5 * (along + 1.0) * PARTS as f32) as usize).min(PARTS - 1);
                    let bin = bin(ys[(2 * column).min(y.width - 1)], us[column], vs[column]);
                    self.parts[part][bin] += 1.0;
                }
            }
        }
        // A chroma sample covers 2 x 2 pixels.
        let expected_samples =
            MIN_WHOLE_SHARE * core::f32::consts::PI * half.0 * half.1 / (4 * stride * stride) as f32;
        for (part, share) in self.parts.iter_mut().zip(PART_AREA_SHARES) {
            smooth_and_normalise(part, share * expected_samples);
        }
    }

    /// Similarity of two layouts, 0 to 1: the mean Bhattacharyya coefficient of the parts.
    pub(crate) fn similarity(&self, other: &Self) -> f32 {
        let pairs = self.parts.iter().flatten().zip(other.parts.iter().flatten());
        pairs.map(|(a, b)| (a * b).sqrt()).sum::<f32>() / PARTS as f32
    }

    /// Moves this layout towards another by the share `rate`.
    pub(crate) fn blend(&mut self, other: &Self, rate: f32) {
        for (bin, &new) in self.parts.iter_mut().flatten().zip(other.parts.iter().flatten()) {
            *bin += rate * (new - *bin);
        }
    }
}

/// Smooths the counts over neighbouring bins, and scales the sum to 1, or to less if it is below `expected`.
fn smooth_and_normalise(bins: &mut [f32], expected: f32) {
    smooth(bins, 1, LEVELS);
    smooth(bins, LEVELS, LEVELS);
    smooth(bins, LEVELS * LEVELS, LEVELS);
    let sum: f32 = bins.iter().sum();
    if sum > 0.0 {
        let scale = 1.0 / sum.max(expected);
        bins.iter_mut().for_each(|bin| *bin *= scale);
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::ColourEncoding;

    use super::*;
    use crate::test_picture::painted;

    const RED: [u8; 3] = [81, 90, 240];
    const GREY: [u8; 3] = [120, 128, 128];
    const CENTRE: (f32, f32) = (60.0, 45.0);

    /// A picture of one colour left of the middle and another right of it.
    fn picture(left: [u8; 3], right: [u8; 3]) -> Picture {
        painted((120, 90), |column, _| if column < 60 { left } else { right })
    }

    fn layout(picture: &Picture, centre: (f32, f32), half: (f32, f32), angle_deg: f32) -> ColourLayout {
        let mut layout = ColourLayout::default();
        layout.count(picture, centre, half, angle_deg.to_radians());
        layout
    }

    #[test]
    fn the_same_colours_at_the_other_end_are_another_layout() {
        let half = (40.0, 20.0);
        let learned = layout(&picture(RED, GREY), CENTRE, half, 0.0);
        assert!((learned.similarity(&learned) - 1.0).abs() < 1e-5);
        let swapped = layout(&picture(GREY, RED), CENTRE, half, 0.0);
        // Of the three parts, only the middle one has both colours either way.
        assert!((learned.similarity(&swapped) - 1.0 / 3.0).abs() < 0.05, "{}", learned.similarity(&swapped));
        let turned = layout(&picture(GREY, RED), CENTRE, half, 180.0);
        assert!((learned.similarity(&turned) - 1.0).abs() < 0.01, "{}", learned.similarity(&turned));
    }

    #[test]
    fn parts_outside_of_the_picture_are_like_nothing() {
        let picture = picture(RED, RED);
        let learned = layout(&picture, CENTRE, (30.0, 20.0), 0.0);
        for (u, parts) in [(-10.0, 1.0), (10.0, 2.0)] {
            let cut = layout(&picture, (u, 45.0), (30.0, 20.0), 0.0);
            assert!(
                (learned.similarity(&cut) - parts / 3.0).abs() < 0.01,
                "{u}: {}",
                learned.similarity(&cut)
            );
        }
        let beyond = layout(&picture, (-60.0, 45.0), (30.0, 20.0), 0.0);
        assert_eq!(learned.similarity(&beyond), 0.0);
    }

    #[test]
    fn a_layout_can_be_counted_anywhere_in_pictures_of_any_size() {
        for (width, height) in [(0, 0), (0, 9), (1, 1), (2, 2), (3, 1), (1, 70), (33, 31)] {
            let size = PictureSize::new(width, height);
            let picture = Picture::black(size, ColourEncoding::assumed_for(size));
            for half in [(0.0, 0.0), (3.0, 1.0), (500.0, 700.0)] {
                for centre in [(0.0, 0.0), (16.0, 15.0), (1e9, -1e9)] {
                    let similarity =
                        layout(&picture, centre, half, 30.0).similarity(&ColourLayout::default());
                    assert_eq!(similarity, 0.0);
                }
            }
        }
    }

    #[test]
    fn every_colour_has_a_bin() {
        for level in 0..=255 {
            assert!(bin(level, 255 - level, level / 2) < BINS);
        }
        assert_eq!((bin(0, 0, 0), bin(255, 255, 255)), (0, BINS - 1));
    }
}
