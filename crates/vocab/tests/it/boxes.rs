//! Boxes: emptiness, clipping, and intersection over union.

use barrelman_vocab::{PictureSize, PixelBox, PixelPoint};
use proptest::prelude::*;

const PICTURE: PictureSize = PictureSize::new(640, 480);

fn pixel_box(u: f64, v: f64, w: f64, h: f64) -> PixelBox {
    PixelBox { u, v, w, h }
}

#[test]
fn the_middle_of_a_box_is_its_centre() {
    assert_eq!(pixel_box(10.0, 20.0, 4.0, 8.0).centre(), PixelPoint { u: 12.0, v: 24.0 });
    assert_eq!(PICTURE.bounds().centre(), PICTURE.centre());
}

#[test]
fn a_box_without_a_width_a_height_or_a_number_is_empty() {
    let check = |w: f64, h: f64, expected: bool| assert_eq!(pixel_box(1.0, 1.0, w, h).is_empty(), expected);
    check(1.0, 1.0, false);
    check(1e-9, 1.0, false);
    check(0.0, 1.0, true);
    check(1.0, 0.0, true);
    check(-0.0, 1.0, true);
    check(-3.0, -3.0, true);
    check(f64::NAN, 1.0, true);
    check(1.0, f64::INFINITY, true);
    assert!(pixel_box(f64::NAN, 1.0, 1.0, 1.0).is_empty());
    assert!(pixel_box(1.0, f64::NEG_INFINITY, 1.0, 1.0).is_empty());
}

#[test]
fn an_empty_box_covers_nothing() {
    for empty in [
        pixel_box(0.0, 0.0, -2.0, -2.0),
        pixel_box(0.0, 0.0, f64::NAN, 2.0),
        pixel_box(0.0, f64::NAN, 2.0, 2.0),
    ] {
        assert_eq!(empty.area(), 0.0);
        assert_eq!(empty.iou(PICTURE.bounds()), 0.0);
        assert_eq!(PICTURE.bounds().iou(empty), 0.0);
        assert_eq!(empty.iou(empty), 0.0);
    }
}

#[test]
fn clipping_keeps_what_lies_in_the_picture() {
    let check = |whole: PixelBox, expected: PixelBox| assert_eq!(whole.clipped(PICTURE), expected);
    check(pixel_box(10.0, 20.0, 30.0, 40.0), pixel_box(10.0, 20.0, 30.0, 40.0));
    check(pixel_box(-10.0, -20.0, 30.0, 40.0), pixel_box(0.0, 0.0, 20.0, 20.0));
    check(pixel_box(630.0, 470.0, 30.0, 40.0), pixel_box(630.0, 470.0, 10.0, 10.0));
    check(pixel_box(-10.0, -10.0, 1000.0, 1000.0), PICTURE.bounds());
}

#[test]
fn what_lies_outside_the_picture_or_nowhere_is_clipped_to_nothing() {
    let check = |whole: PixelBox| assert!(whole.clipped(PICTURE).is_empty(), "{whole}");
    check(pixel_box(640.0, 0.0, 10.0, 10.0));
    check(pixel_box(0.0, 480.0, 10.0, 10.0));
    check(pixel_box(-10.0, 0.0, 10.0, 10.0));
    check(pixel_box(50.0, 50.0, 0.0, 10.0));
    check(pixel_box(50.0, 50.0, -20.0, 10.0));
    check(pixel_box(f64::NAN, 50.0, 10.0, 10.0));
    check(pixel_box(50.0, f64::NAN, 10.0, 10.0));
    check(pixel_box(50.0, 50.0, f64::NAN, 10.0));
    check(pixel_box(50.0, 50.0, 10.0, f64::NAN));
    check(pixel_box(f64::NAN, f64::NAN, f64::NAN, f64::NAN));
    assert!(pixel_box(0.0, 0.0, 10.0, 10.0).clipped(PictureSize::new(0, 480)).is_empty());
}

#[test]
fn iou_is_intersection_over_union() {
    let check = |a: PixelBox, b: PixelBox, expected: f64| {
        assert_eq!(a.iou(b), expected, "{a} with {b}");
        assert_eq!(b.iou(a), expected, "{b} with {a}");
    };
    check(pixel_box(0.0, 0.0, 2.0, 2.0), pixel_box(0.0, 0.0, 2.0, 2.0), 1.0);
    check(pixel_box(0.0, 0.0, 2.0, 2.0), pixel_box(1.0, 0.0, 2.0, 2.0), 1.0 / 3.0);
    check(pixel_box(0.0, 0.0, 2.0, 2.0), pixel_box(1.0, 1.0, 2.0, 2.0), 1.0 / 7.0);
    check(pixel_box(0.0, 0.0, 2.0, 2.0), pixel_box(2.0, 0.0, 2.0, 2.0), 0.0);
    check(pixel_box(0.0, 0.0, 4.0, 4.0), pixel_box(1.0, 1.0, 1.0, 1.0), 1.0 / 16.0);
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -1000.0..1000.0, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)]
}

fn any_box() -> impl Strategy<Value = PixelBox> {
    (any_number(), any_number(), any_number(), any_number()).prop_map(|(u, v, w, h)| PixelBox { u, v, w, h })
}

proptest! {
    #[test]
    fn iou_lies_between_0_and_1(a in any_box(), b in any_box()) {
        let iou = a.iou(b);
        prop_assert!((0.0..=1.0).contains(&iou), "{iou}");
        prop_assert!((0.0..=1.0).contains(&a.iou(a)), "{}", a.iou(a));
    }

    #[test]
    fn a_clipped_box_lies_in_the_picture_or_is_empty(any in any_box()) {
        let clipped = any.clipped(PICTURE);
        let within = clipped.u >= 0.0 && clipped.v >= 0.0
            && clipped.u + clipped.w <= 640.0 && clipped.v + clipped.h <= 480.0;
        prop_assert!(clipped.is_empty() || within, "{clipped}");
        prop_assert!(!any.is_empty() || clipped.is_empty(), "{any} became {clipped}");
    }
}

#[test]
fn a_box_is_printed_to_the_tenth_of_a_pixel() {
    let bounds = PixelBox { u: 428.731_129_646, v: 240.0, w: 80.06, h: -0.01 };
    assert_eq!(bounds.to_string(), "428.7,240,80.1,0");
}
