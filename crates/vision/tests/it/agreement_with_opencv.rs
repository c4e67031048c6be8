//! Agreement with OpenCV, whose results are the fixtures; `fixtures/camshift/make.py` made and documents
//! them.
#![allow(clippy::disallowed_methods, reason = "a test reads its fixtures from files")]

use std::path::PathBuf;

use barrelman_vision::{
    BELOW_FLOORS, CamShiftConfig, Floors, SearchResult, TerminationCriteria, WeightMap, Window, YuvToHue,
    cam_shift,
};
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};

fn fixture(name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/camshift");
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The rows of a CSV file without its header: the first field, and the numbers after the first `names`
/// columns.
fn rows(name: &str, names: usize) -> Vec<(String, Vec<f64>)> {
    let text = String::from_utf8(fixture(name)).unwrap();
    let row = |line: &str| {
        let name = line.split(',').next().unwrap().to_owned();
        (name, line.split(',').skip(names).map(|field| field.parse().unwrap()).collect())
    };
    text.lines().skip(1).map(row).collect()
}

/// Width, height and samples of a binary PGM file.
fn grey_map(bytes: &[u8]) -> (usize, usize, &[u8]) {
    let mut fields = bytes.splitn(4, |byte| byte.is_ascii_whitespace());
    assert_eq!(fields.next().unwrap(), b"P5");
    let mut number = || std::str::from_utf8(fields.next().unwrap()).unwrap().parse().unwrap();
    let (width, height) = (number(), number());
    let samples = &bytes[bytes.len() - width * height..];
    (width, height, samples)
}

const PAPER: TerminationCriteria = TerminationCriteria { max_iterations: 10, epsilon_px: 1.0 };

/// A start window of the fixtures, which may lie partly outside the map.
fn start_window(numbers: &[f64]) -> Window {
    let (left, top) = (numbers[0].max(0.0), numbers[1].max(0.0));
    let (right, bottom) = (numbers[0] + numbers[2], numbers[1] + numbers[3]);
    let whole = |number: f64| number as usize;
    Window { x: whole(left), y: whole(top), w: whole(right - left), h: whole(bottom - top) }
}

#[test]
fn the_same_back_projection_gives_the_same_window_centre_size_and_angle() {
    let cases = rows("ellipses.csv", 1);
    assert!(cases.len() >= 20);
    for (name, numbers) in cases {
        let file = fixture(&format!("{name}.pgm"));
        let (width, height, samples) = grey_map(&file);
        let found = cam_shift(&mut WeightMap::new(samples, width, height), start_window(&numbers), PAPER);
        let window = Window {
            x: numbers[4] as usize,
            y: numbers[5] as usize,
            w: numbers[6] as usize,
            h: numbers[7] as usize,
        };
        let [centre_x, centre_y, minor, major, angle] = numbers[8..] else {
            panic!("{name}: a row of another length");
        };
        if major == 0.0 && centre_x == 0.0 {
            assert_eq!(found, SearchResult::NotFound(window), "{name}");
            continue;
        }
        let SearchResult::Found(target) = found else {
            panic!("{name}: no target found");
        };
        assert_eq!(target.window, window, "{name}");
        // OpenCV's centre is that of the window. It lies on half pixels, and off the centroid where the
        // window is clipped at the left or the top. The centroid itself is rounded, and counted from the
        // centre of pixel 0, which is 0.5 here. Both may therefore differ by one pixel along each axis.
        let middle = target.window.to_pixel_box().centre();
        assert_eq!((middle.u, middle.v), (centre_x, centre_y), "{name}");
        if window.x > 0 && window.y > 0 {
            let (u, v) = (target.centroid.u, target.centroid.v);
            assert!((u - centre_x).abs() <= 1.0, "{name}: {u} against {centre_x}");
            assert!((v - centre_y).abs() <= 1.0, "{name}: {v} against {centre_y}");
        }
        // The integer sums and the formulas are equal. OpenCV uses single precision, and the fixture four
        // decimals.
        assert!((target.major_px - major).abs() <= 1e-3, "{name}: {} against {major}", target.major_px);
        assert!((target.minor_px - minor).abs() <= 1e-3, "{name}: {} against {minor}", target.minor_px);
        // A round target has no axis: OpenCV's is arbitrary, too.
        if major > 1.01 * minor {
            // OpenCV's angle is clockwise from the vertical.
            let expected = (90.0 - angle).rem_euclid(180.0);
            let off = (target.axis.degrees() - expected).abs();
            assert!(off.min(180.0 - off) <= 0.01, "{name}: {} against {expected}", target.axis.degrees());
        }
    }
}

fn check_colours(name: &str, matrix: ColourMatrix, range: SampleRange) {
    let config = CamShiftConfig::default();
    let floors = Floors { saturation: config.saturation_floor, value: config.value_floor };
    let colours = rows(name, 0);
    let (mut above, mut same_bin, mut same_floors) = (0, 0, 0);
    let hue = YuvToHue::new(ColourEncoding { matrix, range });
    let bin = |code: u8| usize::from(code) * config.bins / 180;
    for (_, numbers) in &colours {
        let sample = |i: usize| numbers[i] as u8;
        let code = hue.hue_code([sample(0), sample(1), sample(2)], floors);
        let counts = sample(4) >= floors.saturation && sample(5) >= floors.value;
        same_floors += usize::from(counts == (code != BELOW_FLOORS));
        if counts {
            above += 1;
            same_bin += usize::from(code != BELOW_FLOORS && bin(code) == bin(sample(3)));
        }
    }
    assert!(above > colours.len() / 2, "{name}: too few colours above the floors");
    // OpenCV multiplies by rounded reciprocals instead of dividing, so that a hue halfway between two codes
    // may be rounded differently. Measured over the four files: 99.55 to 100 % of the bins are equal, and all
    // decisions.
    assert!(same_bin * 1000 >= above * 995, "{name}: {same_bin} of {above} bins equal");
    assert_eq!(same_floors, colours.len(), "{name}: decisions about the floors");
}

#[test]
fn hues_of_standard_definition_video_are_opencvs() {
    check_colours("colours_bt601_limited.csv", ColourMatrix::Bt601, SampleRange::Limited);
}

#[test]
fn hues_of_jpeg_pictures_are_opencvs() {
    check_colours("colours_bt601_full.csv", ColourMatrix::Bt601, SampleRange::Full);
}

#[test]
fn hues_of_high_definition_video_are_opencvs() {
    check_colours("colours_bt709_limited.csv", ColourMatrix::Bt709, SampleRange::Limited);
}

#[test]
fn hues_of_full_range_high_definition_video_are_opencvs() {
    check_colours("colours_bt709_full.csv", ColourMatrix::Bt709, SampleRange::Full);
}
