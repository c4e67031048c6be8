//! The picture of the runs with a held mark: water with a pattern, and a person at one place.

use barrelman_vocab::video::{ColourEncoding, Picture};
use barrelman_vocab::{PictureSize, PixelPoint};

/// Width and height of the person, pixels.
const PERSON: (usize, usize) = (16, 12);

/// The picture with a person at this place, which is not at its border.
pub(super) fn person_picture(size: PictureSize, at: PixelPoint) -> Picture {
    let mut picture = Picture::black(size, ColourEncoding::JPEG);
    let width = size.width as usize;
    let [y, u, v] = picture.planes_mut();
    for (index, sample) in y.iter_mut().enumerate() {
        let (row, column) = (index / width, index % width);
        *sample = 70 + ((column / 6 * 7 + row / 4 * 13) * 29 % 24) as u8;
    }
    u.fill(150);
    v.fill(110);
    let (left, top) = (at.u as usize - PERSON.0 / 2, at.v as usize - PERSON.1 / 2);
    for (row, column) in (0..PERSON.1).flat_map(|row| (0..PERSON.0).map(move |column| (row, column))) {
        let is_head = (5..11).contains(&column) && row < 5;
        let stripe = 12 * ((column / 4) % 3) as u8;
        y[(top + row) * width + left + column] = if is_head { 30 } else { 190 + stripe };
        let chroma = (top + row) / 2 * (width / 2) + (left + column) / 2;
        (u[chroma], v[chroma]) = if is_head { (125, 135) } else { (80, 190) };
    }
    picture
}
