//! Black bars at the edges of the picture: a letter-boxed or pillar-boxed video. The picture is then wider or
//! higher than what the camera sees, so that its focal length as a share of the width is not the profile's.

use core::fmt;

use barrelman_vocab::{Picture, PictureSize};

/// Every which picture is looked at.
const EVERY: u32 = 15;
/// Number of pictures that must have been looked at.
const MIN_PICTURES: u32 = 4;
/// Samples of a bar are at most this bright, and differ by at most this.
const MAX_LUMA: u8 = 40;
const MAX_SPREAD: u8 = 8;
/// The narrowest bar, as a share of the side of the picture.
const MIN_SHARE: f64 = 0.02;

/// The widths of the bars, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bars {
    /// At the left edge.
    pub left: usize,
    /// At the right edge.
    pub right: usize,
    /// At the upper edge.
    pub top: usize,
    /// At the lower edge.
    pub bottom: usize,
}

impl fmt::Display for Bars {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { left, right, top, bottom } = self;
        write!(f, "{left} px left, {right} right, {top} at the top, {bottom} at the bottom")
    }
}

/// Looks for bars that are there in every picture.
#[derive(Debug, Clone, Default)]
pub(super) struct BarSearch {
    pictures: u32,
    least: Option<(PictureSize, Bars)>,
}

impl BarSearch {
    /// Looks at a picture.
    pub(super) fn add(&mut self, picture: &Picture) {
        let index = self.pictures;
        self.pictures += 1;
        if !index.is_multiple_of(EVERY) {
            return;
        }
        let (size, seen) = (picture.size(), bars(picture));
        let least = match self.least {
            Some((known, least)) if known == size => Bars {
                left: least.left.min(seen.left),
                right: least.right.min(seen.right),
                top: least.top.min(seen.top),
                bottom: least.bottom.min(seen.bottom),
            },
            _ => seen,
        };
        self.least = Some((size, least));
    }

    /// The bars; `None`: there are none of note, or too few pictures were seen.
    pub(super) fn found(&self) -> Option<Bars> {
        let (size, bars) = self.least.filter(|_| self.pictures.div_ceil(EVERY) >= MIN_PICTURES)?;
        let is_wide = |bar: usize, side: u32| bar as f64 >= MIN_SHARE * f64::from(side);
        let is_black = bars.left >= size.width as usize;
        let has_bars = is_wide(bars.left, size.width)
            || is_wide(bars.right, size.width)
            || is_wide(bars.top, size.height)
            || is_wide(bars.bottom, size.height);
        (has_bars && !is_black).then_some(bars)
    }
}

fn bars(picture: &Picture) -> Bars {
    let plane = picture.y();
    let (width, height) = (picture.size().width as usize, picture.size().height as usize);
    let is_row_dark = |row: usize| is_dark(plane.row(row)[..width].iter().copied());
    let is_column_dark = |column: usize| is_dark((0..height).map(|row| plane.row(row)[column]));
    Bars {
        left: (0..width).take_while(|column| is_column_dark(*column)).count(),
        right: (0..width).rev().take_while(|column| is_column_dark(*column)).count(),
        top: (0..height).take_while(|row| is_row_dark(*row)).count(),
        bottom: (0..height).rev().take_while(|row| is_row_dark(*row)).count(),
    }
}

/// Whether all samples are equally dark.
fn is_dark(samples: impl Iterator<Item = u8>) -> bool {
    let (mut low, mut high) = (u8::MAX, 0);
    for sample in samples {
        (low, high) = (low.min(sample), high.max(sample));
        if high > MAX_LUMA || high - low > MAX_SPREAD {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::video::ColourEncoding;

    use super::*;

    const SIZE: PictureSize = PictureSize::new(64, 48);

    /// A picture with stripes between bars of these widths.
    fn picture(bars: Bars) -> Picture {
        let mut picture = Picture::black(SIZE, ColourEncoding::JPEG);
        let [luma, ..] = picture.planes_mut();
        for (row, line) in luma.chunks_mut(64).enumerate() {
            for (column, sample) in line.iter_mut().enumerate() {
                let inside = (bars.left..64 - bars.right).contains(&column)
                    && (bars.top..48 - bars.bottom).contains(&row);
                *sample = if inside { 60 + 10 * ((row + column) % 9) as u8 } else { 16 };
            }
        }
        picture
    }

    fn found(pictures: impl IntoIterator<Item = Bars>) -> Option<Bars> {
        let mut search = BarSearch::default();
        for bars in pictures {
            for _ in 0..EVERY {
                search.add(&picture(bars));
            }
        }
        search.found()
    }

    #[test]
    fn bars_are_found_where_every_picture_has_them() {
        let pillars = Bars { left: 8, right: 7, ..Bars::default() };
        let letters = Bars { top: 5, bottom: 6, ..Bars::default() };
        assert_eq!(found([pillars; 5]), Some(pillars));
        assert_eq!(found([letters; 5]), Some(letters));
        assert_eq!(found([pillars, pillars, letters, pillars, pillars]), None, "the bars do not last");
        assert_eq!(found([Bars::default(); 5]), None);
        assert_eq!(found([pillars; 2]), None, "too few pictures");
        let black = Bars { left: 32, right: 32, top: 24, bottom: 24 };
        assert_eq!(found([black; 5]), None, "a black picture is another fault");
    }
}
