//! A box that a hand draws about a target, as the simulated operator of trials does.

use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{PictureSize, PixelBox};

/// Largest offset of the centre, and range of the sides, in sides of the target.
const MAX_OFFSET: f64 = 0.15;
const SIZES: (f64, f64) = (0.85, 1.5);
/// Smallest box that is drawn: width and height, pixels.
const MIN_BOX_PX: (f64, f64) = (8.0, 6.0);

/// A box about `exact`, within the picture.
pub(super) fn drawn_by_hand(exact: PixelBox, picture: PictureSize, rng: &mut SplitMix64) -> PixelBox {
    let mut centre = exact.centre();
    centre.u += exact.w * rng.between(-MAX_OFFSET, MAX_OFFSET);
    centre.v += exact.h * rng.between(-MAX_OFFSET, MAX_OFFSET);
    let w = (exact.w * rng.between(SIZES.0, SIZES.1)).max(MIN_BOX_PX.0);
    let h = (exact.h * rng.between(SIZES.0, SIZES.1)).max(MIN_BOX_PX.1);
    PixelBox { u: centre.u - 0.5 * w, v: centre.v - 0.5 * h, w, h }.clipped(picture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng_of_name::rng_of_name;

    const PICTURE: PictureSize = PictureSize::new(640, 360);

    #[test]
    fn a_box_drawn_by_hand_is_about_the_target() {
        let exact = PixelBox { u: 300.0, v: 200.0, w: 40.0, h: 20.0 };
        for number in 0..200 {
            let drawn = drawn_by_hand(exact, PICTURE, &mut rng_of_name("clip", number));
            assert!((34.0..=60.0).contains(&drawn.w) && (17.0..=30.0).contains(&drawn.h), "{drawn}");
            let (off_u, off_v) = (drawn.centre().u - 320.0, drawn.centre().v - 210.0);
            assert!(off_u.abs() <= 6.0 + 1e-9 && off_v.abs() <= 3.0 + 1e-9, "{drawn}");
        }
    }

    #[test]
    fn a_tiny_target_is_drawn_as_large_as_a_hand_can() {
        let tiny = PixelBox { u: 300.0, v: 200.0, w: 2.0, h: 1.0 };
        let drawn = drawn_by_hand(tiny, PICTURE, &mut rng_of_name("clip", 1));
        assert_eq!((drawn.w, drawn.h), (8.0, 6.0));
    }
}
