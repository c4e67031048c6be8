//! Pictures for the unit tests of this crate.

use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PictureSize};

/// A picture whose luma is given by column and row.
pub(crate) fn picture(size: (u32, u32), luma: impl Fn(usize, usize) -> f32) -> Picture {
    let size = PictureSize::new(size.0, size.1);
    let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
    let [y, _, _] = picture.planes_mut();
    for (index, sample) in y.iter_mut().enumerate() {
        let width = size.width as usize;
        *sample = luma(index % width, index / width).clamp(0.0, 255.0) as u8;
    }
    picture
}

/// A picture whose colour (Y, U, V) is given by column and row. A chroma sample has the colour of the first
/// of its four pixels.
pub(crate) fn painted(size: (u32, u32), colour: impl Fn(usize, usize) -> [u8; 3]) -> Picture {
    let size = PictureSize::new(size.0, size.1);
    let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
    for (plane, (samples, step)) in picture.planes_mut().into_iter().zip([1, 2, 2]).enumerate() {
        let width = (size.width as usize).div_ceil(step);
        for (index, sample) in samples.iter_mut().enumerate() {
            *sample = colour(index % width * step, index / width * step)[plane];
        }
    }
    picture
}

/// A picture of smooth noise; `place` gives which of it a pixel shows.
pub(crate) fn smooth_noise(size: PictureSize, place: impl Fn(f64, f64) -> (f64, f64)) -> Picture {
    let corner = |x: i64, y: i64| {
        let mut state = (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663)) as u32;
        state = (state ^ (state >> 15)).wrapping_mul(0x2c1b_3c6d);
        f64::from((state ^ (state >> 12)).wrapping_mul(0x297a_2d39) >> 24)
    };
    picture((size.width, size.height), |column, row| {
        let (x, y) = place(column as f64, row as f64);
        let (x, y) = (x / 5.0, y / 5.0);
        let (i, j, p, q) =
            (x.floor() as i64, y.floor() as i64, x.fract().rem_euclid(1.0), y.fract().rem_euclid(1.0));
        let top = corner(i, j) * (1.0 - p) + corner(i + 1, j) * p;
        let bottom = corner(i, j + 1) * (1.0 - p) + corner(i + 1, j + 1) * p;
        (top * (1.0 - q) + bottom * q) as f32
    })
}
