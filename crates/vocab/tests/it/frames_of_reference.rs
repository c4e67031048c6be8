//! Pixel coordinates and image coordinates.

use barrelman_vocab::{ImagePoint, PictureSize, PixelPoint};
use proptest::prelude::*;

#[test]
fn x_counts_to_the_right_and_y_upwards_from_the_centre() {
    let check = |(width, height), (u, v), (x, y)| {
        let (picture, pixel) = (PictureSize::new(width, height), PixelPoint { u, v });
        let image = ImagePoint { x, y };
        assert_eq!(pixel.in_image(picture), image, "{picture}");
        assert_eq!(image.in_pixels(picture), pixel, "{picture}");
    };
    check((640, 480), (320.0, 240.0), (0.0, 0.0));
    check((640, 480), (0.0, 0.0), (-320.0, 240.0));
    check((640, 480), (640.0, 480.0), (320.0, -240.0));
    check((640, 480), (0.5, 0.5), (-319.5, 239.5));
    check((5, 3), (2.5, 1.5), (0.0, 0.0));
    check((5, 3), (0.0, 3.0), (-2.5, -1.5));
    check((0, 0), (1.0, 1.0), (1.0, -1.0));
}

#[test]
fn the_centre_of_a_picture_has_no_negative_zero() {
    let picture = PictureSize::new(640, 480);
    let centre = picture.centre().in_image(picture);
    assert!(centre.x.is_sign_positive() && centre.y.is_sign_positive());
}

proptest! {
    /// Sixteenths of a pixel in pictures up to 16,384 pixels wide are exact in a double, and so is the
    /// conversion in both directions.
    #[test]
    fn there_and_back_is_the_same_point(
        width in 0_u32..16_384, height in 0_u32..16_384, u in -1_000_000..1_000_000, v in -1_000_000..1_000_000,
    ) {
        let picture = PictureSize::new(width, height);
        let point = PixelPoint { u: f64::from(u) / 16.0, v: f64::from(v) / 16.0 };
        prop_assert_eq!(point.in_image(picture).in_pixels(picture), point);
    }
}
