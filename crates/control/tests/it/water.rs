//! Points on the water: round trips, the horizon, uncertainty, and agreement with OpenCV, whose results are
//! the fixtures; `fixtures/water/make.py` made and documents them.
#![allow(clippy::disallowed_methods, reason = "a test reads its fixtures from files")]

use std::path::PathBuf;

use barrelman_control::camera_model::lens_in_force;
use barrelman_control::water::lens_fault::{LensFault, fault_of};
use barrelman_control::water::{MIN_DEPRESSION, WaterView, lens};
use barrelman_vocab::profile::CameraDynamics;
use barrelman_vocab::{
    Angle, BrownConrady, CameraAboveWater, Distortion, Lens, PictureSize, PixelPoint, Sighting,
    SightingNoise, WaterPoint,
};
use proptest::prelude::*;

const PICTURE: PictureSize = PictureSize::new(1280, 720);

/// The webcam of the paper's laboratory, scaled to this picture.
const WEBCAM: BrownConrady = BrownConrady { k1: 0.0543, k2: -0.594, p1: 0.0, p2: 0.0, k3: 1.957 };

fn rows<const N: usize>(name: &str) -> Vec<[f64; N]> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/water").join(name);
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .skip(1)
        .map(|line| {
            let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap()).collect();
            values.try_into().unwrap()
        })
        .collect()
}

fn camera(height_m: f64, pan: f64, tilt: f64, roll: f64) -> CameraAboveWater {
    let angle = Angle::from_radians;
    let below = WaterPoint::default();
    CameraAboveWater { below, height_m, pan: angle(pan), tilt: angle(tilt), roll: angle(roll) }
}

fn angle_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let norm = |v: [f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    norm(cross) / (norm(a) * norm(b))
}

#[test]
fn pixels_are_those_of_opencv() {
    let mut max_px: f64 = 0.0;
    let mut max_m: f64 = 0.0;
    for [fx, fy, cx, cy, k1, k2, p1, p2, k3, height, pan, tilt, roll, x, y, u, v] in rows("projected.csv") {
        let lens = Lens {
            picture: PICTURE,
            focal_px: (fx, fy),
            principal: PixelPoint { u: cx + 0.5, v: cy + 0.5 },
            distortion: Distortion::BrownConrady(BrownConrady { k1, k2, p1, p2, k3 }),
        };
        let view = WaterView::new(lens, &camera(height, pan, tilt, roll));
        let point = WaterPoint { x, y };
        let seen = view.pixel_of_water(point).unwrap();
        max_px = max_px.max((seen.u - 0.5 - u).abs()).max((seen.v - 0.5 - v).abs());
        let back = view.sighting(PixelPoint { u: u + 0.5, v: v + 0.5 }).point().unwrap();
        max_m = max_m.max(back.distance_to(point) / back.distance_to(WaterPoint::default()));
    }
    assert!(max_px < 1e-8, "{max_px} px from OpenCV's projections");
    assert!(max_m < 1e-9, "{max_m} of the distance from the points that OpenCV projected");
}

#[test]
fn the_simulators_distortion_is_the_inverse_of_opencvs() {
    for [k, x, y, distorted_x, distorted_y] in rows("barrel.csv") {
        let lens = Lens { principal: PixelPoint::default(), ..Lens::barrel(PICTURE, 1.0, k) };
        let seen = lens::pixel_of(&lens, [x, y]).unwrap();
        let off = (seen.u - distorted_x).abs().max((seen.v - distorted_y).abs());
        assert!(off < 1e-12, "k {k} at {x}, {y}: {off}");
    }
}

fn any_distortion() -> impl Strategy<Value = Distortion> {
    prop_oneof![
        Just(Distortion::None),
        (0.0..0.3_f64).prop_map(|k| Distortion::Barrel { k }),
        Just(Distortion::BrownConrady(WEBCAM)),
        (-0.12..0.12_f64, -0.01..0.01_f64, -2e-3..2e-3_f64, -2e-3..2e-3_f64).prop_map(|(k1, k2, p1, p2)| {
            Distortion::BrownConrady(BrownConrady { k1, k2, p1, p2, k3: 0.0 })
        }),
    ]
}

fn any_view() -> impl Strategy<Value = WaterView> {
    let attitude = (-7.0..7.0_f64, -1.57..0.3_f64, -0.5..0.5_f64);
    (any_distortion(), 600.0..1500.0_f64, 0.5..120.0_f64, attitude, -500.0..500.0_f64).prop_map(
        |(distortion, focal_px, height, (pan, tilt, roll), off)| {
            let lens = Lens { distortion, ..Lens::pinhole(PICTURE, focal_px) };
            let below = WaterPoint { x: off, y: -0.5 * off };
            WaterView::new(lens, &CameraAboveWater { below, ..camera(height, pan, tilt, roll) })
        },
    )
}

proptest! {
    /// Pixel, line of sight, pixel, line of sight.
    #[test]
    fn a_line_of_sight_comes_back_within_a_nanoradian(
        view in any_view(), u in 0.0..1280.0_f64, v in 0.0..720.0_f64
    ) {
        let pixel = PixelPoint { u, v };
        let direction = view.direction_of(pixel);
        prop_assume!(direction.is_some(), "the corners of some of these lenses have no line of sight");
        let direction = direction.unwrap();
        let again = view.pixel_of(direction).unwrap();
        prop_assert!((again.u - u).abs() < 1e-8 && (again.v - v).abs() < 1e-8, "{pixel:?} {again:?}");
        let off = angle_between(direction, view.direction_of(again).unwrap());
        prop_assert!(off < 1e-11, "{off} rad");
    }

    /// From 5 degrees below the horizon on, a point on the water comes back within a millimetre (a thousandth
    /// of that at these heights).
    #[test]
    fn a_point_on_the_water_comes_back(
        view in any_view(), u in 0.0..1280.0_f64, v in 0.0..720.0_f64
    ) {
        let pixel = PixelPoint { u, v };
        let Some([_, _, up]) = view.direction_of(pixel) else {
            prop_assert!(matches!(view.sighting(pixel), Sighting::OutsideLens));
            return Ok(());
        };
        match view.sighting(pixel) {
            Sighting::OnWater(point) => {
                let seen = view.pixel_of_water(point).unwrap();
                let again = view.sighting(seen).point().unwrap_or(point);
                if up < -5.0_f64.to_radians().sin() {
                    prop_assert!(again.distance_to(point) < 1e-6, "{point:?} {again:?}");
                }
                prop_assert!(up <= -MIN_DEPRESSION.radians().sin() + 1e-12);
            }
            Sighting::AtHorizon { depression } => {
                prop_assert!(depression.radians() < MIN_DEPRESSION.radians() + 1e-12);
                prop_assert!((depression.radians().sin() + up).abs() < 1e-12);
            }
            Sighting::OutsideLens => prop_assert!(false, "{pixel:?} has a line of sight"),
        }
    }

    /// The inverse of a lens holds to 1e-12, or there is none.
    #[test]
    fn an_inverted_lens_is_exact_or_absent(
        k1 in -0.6..0.6_f64, k2 in -0.6..0.6_f64, k3 in -2.0..2.0_f64, p1 in -0.02..0.02_f64, p2 in -0.02..0.02_f64,
        u in -400.0..1680.0_f64, v in -400.0..1120.0_f64
    ) {
        let distortion = Distortion::BrownConrady(BrownConrady { k1, k2, p1, p2, k3 });
        let lens = Lens { distortion, ..Lens::pinhole(PICTURE, 700.0) };
        if let Some(tangents) = lens::tangents_of(&lens, PixelPoint { u, v }) {
            let seen = lens::pixel_of(&lens, tangents).unwrap();
            let off = ((seen.u - u) / 700.0).abs().max(((seen.v - v) / 700.0).abs());
            prop_assert!(off < 4.0 * lens::RESIDUAL, "{off}");
        }
    }

    /// The covariance is that of finite differences.
    #[test]
    fn a_covariance_is_that_of_small_changes(
        distortion in any_distortion(), height in 1.0..60.0_f64, pan in -3.0..3.0_f64, tilt in -1.5..-0.2_f64,
        roll in -0.4..0.4_f64, u in 100.0..1180.0_f64, v in 100.0..620.0_f64
    ) {
        let lens = Lens { distortion, ..Lens::pinhole(PICTURE, 900.0) };
        let at = |height: f64, pan: f64, tilt: f64, roll: f64, u: f64, v: f64| {
            WaterView::new(lens, &camera(height, pan, tilt, roll)).sighting(PixelPoint { u, v }).point()
        };
        let noise = SightingNoise {
            pixel_px: 2.0,
            height_m: 0.3,
            pan: Angle::from_degrees(0.5),
            tilt: Angle::from_degrees(1.0),
            roll: Angle::from_degrees(0.7),
        };
        let view = WaterView::new(lens, &camera(height, pan, tilt, roll));
        let depression = -view.direction_of(PixelPoint { u, v }).unwrap()[2];
        prop_assume!(depression > 0.1);
        let fix = view.fix(PixelPoint { u, v }, &noise).unwrap();
        let values = [height, pan, tilt, roll, u, v];
        let std_devs = [
            0.3, noise.pan.radians(), noise.tilt.radians(), noise.roll.radians(), 2.0, 2.0,
        ];
        let mut expected = [0.0; 3];
        for (index, std_dev) in std_devs.into_iter().enumerate() {
            let shifted = |by: f64| {
                let mut values = values;
                values[index] += by;
                let [height, pan, tilt, roll, u, v] = values;
                at(height, pan, tilt, roll, u, v).unwrap()
            };
            let step = if index < 4 { 1e-5 } else { 1e-3 };
            let (x, y) = shifted(-step).vector_to(shifted(step));
            let (x, y) = (x / (2.0 * step) * std_dev, y / (2.0 * step) * std_dev);
            for (sum, product) in expected.iter_mut().zip([x * x, x * y, y * y]) {
                *sum += product;
            }
        }
        let found = [fix.covariance.xx, fix.covariance.xy, fix.covariance.yy];
        let scale = expected[0] + expected[2];
        for (found, expected) in found.into_iter().zip(expected) {
            prop_assert!((found - expected).abs() < 1e-5 * scale, "{found} {expected}");
        }
    }
}

#[test]
fn no_point_lies_at_or_above_the_horizon() {
    let lens = Lens::pinhole(PICTURE, 900.0);
    let check = |tilt_deg: f64, v: f64, is_on_water: bool| {
        let view = WaterView::new(lens, &camera(10.0, 0.0, tilt_deg.to_radians(), 0.0));
        let sighting = view.sighting(PixelPoint { u: 640.0, v });
        assert_eq!(sighting.point().is_some(), is_on_water, "tilt {tilt_deg}, v {v}: {sighting:?}");
    };
    check(0.0, 360.0, false);
    check(-1.9, 360.0, false);
    check(-2.1, 360.0, true);
    check(-10.0, 0.0, false);
    check(-10.0, 719.0, true);
    check(30.0, 719.0, false);
    check(-90.0, 0.0, true);
}

#[test]
fn values_that_are_not_finite_have_no_point() {
    let view = WaterView::new(Lens::barrel(PICTURE, 900.0, 0.1), &camera(10.0, 0.0, -0.5, 0.0));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(view.sighting(PixelPoint { u: bad, v: 100.0 }), Sighting::OutsideLens);
        assert_eq!(view.pixel_of([bad, 1.0, -1.0]), None);
        assert_eq!(view.pixel_of_water(WaterPoint { x: 0.0, y: bad }), None);
    }
    assert_eq!(view.pixel_of_water(WaterPoint { x: 0.0, y: -100.0 }), None, "behind the camera");
}

#[test]
fn a_lens_is_scaled_with_the_picture() {
    let lens = Lens {
        focal_px: (700.0, 690.0),
        principal: PixelPoint { u: 655.5, v: 350.0 },
        distortion: Distortion::BrownConrady(BrownConrady { k1: -0.1, p1: 1e-3, ..BrownConrady::default() }),
        ..Lens::pinhole(PICTURE, 700.0)
    };
    for (width, height) in [(1280, 720), (640, 360), (1920, 1080), (1920, 1079), (854, 480), (320, 180)] {
        let scaled = lens.scaled_to(PictureSize::new(width, height)).unwrap();
        let share = (f64::from(width) / 1280.0, f64::from(height) / 720.0);
        let pixel = PixelPoint { u: 200.0, v: 650.0 };
        let same = PixelPoint { u: share.0 * pixel.u, v: share.1 * pixel.v };
        let (seen, expected) =
            (lens::tangents_of(&scaled, same).unwrap(), lens::tangents_of(&lens, pixel).unwrap());
        let off = (seen[0] - expected[0]).abs().max((seen[1] - expected[1]).abs());
        assert!(off < 1e-11, "{width}x{height}: {off}");
        assert_eq!(scaled.picture, PictureSize::new(width, height));
    }
    for (width, height) in [(640, 480), (1280, 718), (0, 0), (1280, 0), (720, 1280)] {
        assert_eq!(lens.scaled_to(PictureSize::new(width, height)), None, "{width}x{height}");
    }
}

#[test]
fn the_calibrated_lens_is_in_force_until_the_camera_zooms_or_the_picture_changes() {
    let lens = Lens {
        distortion: Distortion::BrownConrady(BrownConrady { k1: -0.1, ..BrownConrady::default() }),
        ..Lens::pinhole(PICTURE, 768.0)
    };
    let camera = CameraDynamics { focal_share: 0.6, lens: Some(lens), ..CameraDynamics::laboratory() };
    let half = PictureSize::new(640, 360);
    assert_eq!(lens_in_force(&camera, 0.6, PICTURE), lens);
    assert_eq!(lens_in_force(&camera, 0.62, half), lens.scaled_to(half).unwrap(), "a nominal field of view");
    assert_eq!(lens_in_force(&camera, 0.7, PICTURE), Lens::pinhole(PICTURE, 0.7 * 1280.0), "a zoom");
    let other = PictureSize::new(640, 480);
    assert_eq!(lens_in_force(&camera, 0.6, other), Lens::pinhole(other, 0.6 * 640.0), "another aspect ratio");
    let pinhole = CameraDynamics { lens: None, ..camera };
    assert_eq!(lens_in_force(&pinhole, 0.6, PICTURE), Lens::pinhole(PICTURE, 0.6 * 1280.0));
}

#[test]
fn a_lens_that_cannot_be_used_is_known_by_its_fault() {
    let good = Lens { distortion: Distortion::BrownConrady(WEBCAM), ..Lens::pinhole(PICTURE, 1120.0) };
    assert_eq!(fault_of(&good), None);
    let with = |model: BrownConrady| Lens { distortion: Distortion::BrownConrady(model), ..good };
    assert_eq!(fault_of(&with(BrownConrady { k3: f64::NAN, ..WEBCAM })), Some(LensFault::NotFinite));
    assert_eq!(fault_of(&Lens { focal_px: (1120.0, f64::INFINITY), ..good }), Some(LensFault::NotFinite));
    assert_eq!(fault_of(&Lens { focal_px: (1120.0, 0.0), ..good }), Some(LensFault::FocalLength));
    assert_eq!(fault_of(&Lens { focal_px: (-1.0, 1120.0), ..good }), Some(LensFault::FocalLength));
    let principal = PixelPoint { u: 1281.0, v: 360.0 };
    assert_eq!(fault_of(&Lens { principal, ..good }), Some(LensFault::PrincipalPoint));
    // r (1 - 0.3 r²) grows up to 0.70: the corners are 734 px from the centre.
    let folding = BrownConrady { k1: -0.3, ..BrownConrady::default() };
    let at = |focal_px: f64| Lens { focal_px: (focal_px, focal_px), ..with(folding) };
    assert_eq!(fault_of(&at(1060.0)), None);
    assert_eq!(fault_of(&at(1040.0)), Some(LensFault::Fold(PixelPoint { u: 0.0, v: 0.0 })));
}

#[test]
fn a_fold_of_the_lens_has_no_line_of_sight() {
    // r (1 - 0.3 r²) has its largest value, 0.70, at r = 1.05.
    let distortion = Distortion::BrownConrady(BrownConrady { k1: -0.3, ..BrownConrady::default() });
    let lens = Lens { distortion, ..Lens::pinhole(PICTURE, 700.0) };
    assert!(lens::tangents_of(&lens, PixelPoint { u: 640.0 + 700.0 * 0.70, v: 360.0 }).is_some());
    assert_eq!(lens::tangents_of(&lens, PixelPoint { u: 640.0 + 700.0 * 0.71, v: 360.0 }), None);
    assert_eq!(lens::pixel_of(&lens, [1.2, 0.0]), None, "seen nearer to the axis than a smaller angle");
}
