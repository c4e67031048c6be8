//! A picture fitted into one of another size: as large as it can be, in the middle, with black bars.
//!
//! A film has one size; its video may change its resolution, or be another camera's.

use barrelman_vocab::video::Plane;
use barrelman_vocab::{Picture, PictureSize};

/// Where a picture lies in another one, in pixels; even, as colours are stored for pairs of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Place {
    /// The largest place in `outer` with the aspect ratio of `inner`.
    fn of(inner: PictureSize, outer: PictureSize) -> Self {
        let scale = f64::min(
            f64::from(outer.width) / f64::from(inner.width),
            f64::from(outer.height) / f64::from(inner.height),
        );
        let even = |length: f64| (length / 2.0).round() as usize * 2;
        let (outer_width, outer_height) = (outer.width as usize, outer.height as usize);
        let width = even(f64::from(inner.width) * scale).clamp(2.min(outer_width), outer_width);
        let height = even(f64::from(inner.height) * scale).clamp(2.min(outer_height), outer_height);
        Self { left: (outer_width - width) / 4 * 2, top: (outer_height - height) / 4 * 2, width, height }
    }

    /// The same place in a plane with half the resolution.
    const fn halved(self) -> Self {
        Self {
            left: self.left / 2,
            top: self.top / 2,
            width: self.width.div_ceil(2),
            height: self.height.div_ceil(2),
        }
    }
}

/// A picture of this size, with `picture` fitted into it.
pub(crate) fn fitted(picture: &Picture, size: PictureSize) -> Picture {
    let mut target = Picture::black(size, picture.colour());
    if picture.size().area() == 0 || size.area() == 0 {
        return target;
    }
    let place = Place::of(picture.size(), size);
    let half = place.halved();
    let widths = [size, target.chroma_size(), target.chroma_size()].map(|size| size.width as usize);
    let sources = [picture.y(), picture.u(), picture.v()];
    for (((out, source), place), width) in
        target.planes_mut().into_iter().zip(sources).zip([place, half, half]).zip(widths)
    {
        draw(source, out, width, place);
    }
    target
}

/// Draws a plane at a place of another, between whose samples it interpolates.
fn draw(source: Plane<'_>, out: &mut [u8], width: usize, place: Place) {
    let columns: Vec<(usize, usize, u32)> =
        (0..place.width).map(|at| between(at, place.width, source.width)).collect();
    for (row, line) in out.chunks_exact_mut(width).skip(place.top).take(place.height).enumerate() {
        let (above, below, down) = between(row, place.height, source.height);
        let (above, below) = (source.row(above), source.row(below));
        for (sample, &(left, right, across)) in line[place.left..].iter_mut().zip(&columns) {
            let mix = |row: &[u8]| u32::from(row[left]) * (256 - across) + u32::from(row[right]) * across;
            *sample = ((mix(above) * (256 - down) + mix(below) * down + (1 << 15)) >> 16) as u8;
        }
    }
}

/// The two samples of `source` around the middle of the pixel `at` of `target` pixels, and the share of the
/// second, in parts of 256.
fn between(at: usize, target: usize, source: usize) -> (usize, usize, u32) {
    let last = source.saturating_sub(1);
    let position = ((at as f64 + 0.5) * source as f64 / target as f64 - 0.5).clamp(0.0, last as f64);
    let first = position as usize;
    (first, (first + 1).min(last), ((position - first as f64) * 256.0) as u32)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::video::ColourEncoding;

    use super::*;

    fn grey(width: u32, height: u32, luma: u8) -> Picture {
        let size = PictureSize::new(width, height);
        let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
        let [y, u, v] = picture.planes_mut();
        y.fill(luma);
        u.fill(90);
        v.fill(200);
        picture
    }

    #[test]
    fn a_picture_of_another_shape_lies_in_the_middle_between_black_bars() {
        let target = fitted(&grey(40, 20, 180), PictureSize::new(80, 80));
        let black = Picture::black(PictureSize::new(2, 2), target.colour()).samples()[0];
        assert_eq!(target.y().row(19), [black; 80]);
        assert_eq!(target.y().row(20), [180; 80]);
        assert_eq!(target.y().row(59), [180; 80]);
        assert_eq!(target.y().row(60), [black; 80]);
        assert_eq!((target.u().row(9)[3], target.u().row(10)[3], target.v().row(29)[39]), (128, 90, 200));
    }

    #[test]
    fn samples_are_interpolated() {
        let mut two = grey(2, 2, 0);
        two.planes_mut()[0].copy_from_slice(&[0, 200, 0, 200]);
        let target = fitted(&two, PictureSize::new(8, 8));
        assert_eq!(target.y().row(3), [0, 0, 25, 75, 125, 175, 200, 200]);
    }

    #[test]
    fn any_sizes_are_taken() {
        for (from, to) in [((1, 1), (4096, 2)), ((3, 500), (5, 7)), ((1920, 1080), (1, 1)), ((7, 7), (8, 6))]
        {
            let target = fitted(&grey(from.0, from.1, 9), PictureSize::new(to.0, to.1));
            assert_eq!(target.size(), PictureSize::new(to.0, to.1));
        }
    }
}
