//! Models of `fixtures/detector`, on drawn pictures.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]

use barrelman_detector::{Detector, ModelError, Objects, Settings};
use barrelman_vocab::PictureSize;
use barrelman_vocab::video::{ColourEncoding, Picture};

macro_rules! fixture {
    ($name:literal) => {
        include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/detector/", $name))
    };
}

const YOLO: &[u8] = fixture!("detector.toml");
const DETR: &[u8] = fixture!("red-detr.toml");

fn load(onnx: &[u8], settings: &[u8]) -> Result<Detector, ModelError> {
    Detector::new(onnx, Settings::from_toml(str::from_utf8(settings).unwrap()).unwrap())
}

/// Green water with red squares of 48 pixels at these left upper corners.
fn water(squares: &[(usize, usize)]) -> Picture {
    let size = PictureSize::new(640, 360);
    let mut picture = Picture::black(size, ColourEncoding::JPEG);
    let [y, u, v] = picture.planes_mut();
    y.fill(110);
    u.fill(128);
    v.fill(110);
    for (left, top) in squares {
        let mut fill = |plane: usize, value: u8| {
            let [y, u, v] = picture.planes_mut();
            let (plane, width, scale) =
                [(y, 640, 1), (u, 320, 2), (v, 320, 2)].into_iter().nth(plane).unwrap();
            for row in plane.chunks_mut(width).skip(top / scale).take(48 / scale) {
                row[left / scale..(left + 48) / scale].fill(value);
            }
        };
        for (plane, value) in [76, 85, 255].into_iter().enumerate() {
            fill(plane, value);
        }
    }
    picture
}

#[track_caller]
fn assert_finds(objects: &Objects, squares: &[(usize, usize)]) {
    assert_eq!((objects.found.len(), objects.not_finite), (squares.len(), 0), "{objects:?}");
    for (left, top) in squares {
        let is_at = |bounds: barrelman_vocab::PixelBox| {
            (bounds.u - *left as f64).abs() < 13.0 && (bounds.v - *top as f64).abs() < 13.0
        };
        let object = objects.found.iter().find(|object| is_at(object.bounds));
        let object = object.unwrap_or_else(|| panic!("({left}, {top}): {objects:?}"));
        // Shares of the input are 32-bit floating-point numbers.
        let is_side = |side: f64| (side - 48.0).abs() < 1e-4;
        assert!(is_side(object.bounds.w) && is_side(object.bounds.h) && object.class == 0, "{object:?}");
        assert!((0.5..=1.0).contains(&object.score), "{objects:?}");
    }
}

#[test]
fn both_formats_find_what_is_red() {
    for (onnx, settings) in [(&fixture!("red-yolo.onnx")[..], YOLO), (&fixture!("red-detr.onnx")[..], DETR)] {
        let mut detector = load(onnx, settings).unwrap();
        let squares = [(96, 48), (480, 240)];
        assert_finds(&detector.detect(&water(&squares)).unwrap(), &squares);
        assert_finds(&detector.detect(&water(&squares[1..])).unwrap(), &squares[1..]);
        assert_finds(&detector.detect(&water(&[])).unwrap(), &[]);
    }
}

#[test]
fn a_picture_of_another_size_is_fitted_into_the_input() {
    let mut detector = load(fixture!("red-yolo.onnx"), YOLO).unwrap();
    for size in [PictureSize::new(2, 2), PictureSize::new(31, 17), PictureSize::new(400, 800)] {
        let objects = detector.detect(&Picture::black(size, ColourEncoding::JPEG)).unwrap();
        assert_eq!(objects, Objects::default(), "{size:?}");
    }
}

#[test]
fn malformed_models_are_refused_with_the_reason() {
    let cases: [(&str, &[u8], &str); 8] = [
        ("empty", b"", "not a model in ONNX"),
        ("no model", fixture!("make_models.py"), "not a model in ONNX"),
        ("truncated", fixture!("truncated.onnx"), "not a model in ONNX"),
        ("unknown operator", fixture!("unknown-operator.onnx"), "Wish"),
        ("grey input", fixture!("grey-input.onnx"), "takes an input of [1, 1, 90, 160]"),
        (
            "seven values",
            fixture!("seven-values.onnx"),
            "answers [1, 7, 350], but the settings make [1, 5, N]",
        ),
        ("not a number", fixture!("not-a-number.onnx"), "each of the 350 boxes"),
        ("too many boxes", fixture!("too-many-boxes.onnx"), "answers 200000 boxes"),
    ];
    for (name, onnx, expected) in cases {
        let Err(error) = load(onnx, YOLO) else { panic!("{name} is usable") };
        let text = error.to_string();
        assert!(text.contains(expected) && !text.contains('\n'), "{name}: {text}");
    }
}

#[test]
fn an_input_of_another_size_is_refused_with_both_sizes() {
    let settings = str::from_utf8(YOLO).unwrap().replace("height = 90", "height = 96");
    let Err(error) = load(fixture!("red-yolo.onnx"), settings.as_bytes()) else { panic!("it is usable") };
    let text = error.to_string();
    assert!(text.contains("[1, 3, 90, 160]") && text.contains("[1, 3, 96, 160]"), "{text}");
}

#[test]
fn numbers_that_are_not_finite_are_no_objects() {
    let mut detector = load(fixture!("dark-only.onnx"), YOLO).unwrap();
    let objects = detector.detect(&water(&[(96, 48)])).unwrap();
    assert_eq!((objects.found.len(), objects.not_finite), (0, 350));
}
