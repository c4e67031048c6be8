//! A part of a picture, as another camera would have filmed it.

use barrelman_vocab::video::Plane;
use barrelman_vocab::{Picture, PictureSize};

/// The part of a picture from a corner on even pixels on.
pub(super) fn crop(from: &Picture, (left, top): (usize, usize), size: PictureSize) -> Picture {
    let mut to = Picture::black(size, from.colour());
    let (width, chroma) = (size.width as usize, to.chroma_size().width as usize);
    let copy = |from: Plane<'_>, to: &mut [u8], width: usize, left: usize, top: usize| {
        for (row, out) in to.chunks_exact_mut(width).enumerate() {
            out.copy_from_slice(&from.row(top + row)[left..left + width]);
        }
    };
    let [y, u, v] = to.planes_mut();
    copy(from.y(), y, width, left, top);
    copy(from.u(), u, chroma, left / 2, top / 2);
    copy(from.v(), v, chroma, left / 2, top / 2);
    to
}
