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
