//! A box that a hand draws about a target.

use barrelman_vocab::{PictureSize, PixelBox};

/// Largest offset of the centre, in sizes of the target.
const MAX_OFFSET: f64 = 0.15;
/// Smallest and largest size, in sizes of the target.
const SIZES: (f64, f64) = (0.85, 1.5);
/// Smallest box that is drawn: width and height, pixels.
pub(super) const MIN_BOX_PX: (f64, f64) = (8.0, 6.0);

/// A box about `bounds` as a hand draws it, within the picture. `between` gives a uniform random number
/// between two bounds for each index from 0 to 3, in this order.
pub fn drawn_by_hand(
    bounds: PixelBox,
    picture: PictureSize,
    mut between: impl FnMut(u64, (f64, f64)) -> f64,
) -> PixelBox {
    let mut centre = bounds.centre();
    centre.u += bounds.w * between(0, (-MAX_OFFSET, MAX_OFFSET));
    centre.v += bounds.h * between(1, (-MAX_OFFSET, MAX_OFFSET));
    let w = (bounds.w * between(2, SIZES)).max(MIN_BOX_PX.0);
    let h = (bounds.h * between(3, SIZES)).max(MIN_BOX_PX.1);
    PixelBox { u: centre.u - 0.5 * w, v: centre.v - 0.5 * h, w, h }.clipped(picture)
}
