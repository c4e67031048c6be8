//! The motor schema: releaser, sectors, ties.

use barrelman_control::{MotorSchema, Percept, Region, Sector};
use barrelman_vocab::profile::{AxisRates, RegionShares};
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, PictureSize};
use proptest::prelude::*;

const PAN: f64 = 0.3;
const TILT: f64 = 0.2;
const LABORATORY: Region = Region { a_px: 192.0, b_px: 120.0 };

fn schema() -> MotorSchema {
    MotorSchema::new(AxisRates {
        pan: AngularRate::from_radians_per_second(PAN),
        tilt: AngularRate::from_radians_per_second(TILT),
    })
}

fn command_at(x: f64, y: f64) -> CameraCommand {
    schema().command(&Percept::new(ImagePoint { x, y }, LABORATORY))
}

#[track_caller]
fn check(x: f64, y: f64, pan: f64, tilt: f64) {
    let command = command_at(x, y);
    let got = (command.pan.radians_per_second(), command.tilt.radians_per_second());
    assert_eq!(got, (pan, tilt), "target at ({x}, {y})");
}

#[test]
fn inside_and_on_the_ellipse_the_camera_rests() {
    check(0.0, 0.0, 0.0, 0.0);
    check(192.0, 0.0, 0.0, 0.0);
    check(-192.0, 0.0, 0.0, 0.0);
    check(0.0, 120.0, 0.0, 0.0);
    check(0.0, -120.0, 0.0, 0.0);
    check(100.0, -80.0, 0.0, 0.0);
}

#[test]
fn each_sector_turns_its_own_axis_towards_the_target() {
    check(193.0, 0.0, PAN, 0.0);
    check(-193.0, 0.0, -PAN, 0.0);
    check(0.0, 121.0, 0.0, TILT);
    check(0.0, -121.0, 0.0, -TILT);
}

#[test]
fn sectors_are_divided_by_the_pixel_diagonals_not_by_the_ellipse() {
    // If scaled by the ellipse (200/192 against 190/120), this point would lie in the top sector.
    check(200.0, 190.0, PAN, 0.0);
    check(190.0, 200.0, 0.0, TILT);
    check(-200.0, -190.0, -PAN, 0.0);
    check(-190.0, -200.0, 0.0, -TILT);
}

#[test]
fn on_a_diagonal_the_right_half_tilts_and_the_left_half_pans() {
    check(150.0, 150.0, 0.0, TILT);
    check(150.0, -150.0, 0.0, -TILT);
    check(-150.0, -150.0, -PAN, 0.0);
    check(-150.0, 150.0, -PAN, 0.0);
}

#[test]
fn the_region_is_a_share_of_the_picture() {
    let shares = RegionShares { half_width: 0.6, half_height: 0.5 };
    assert_eq!(Region::from_shares(shares, PictureSize::new(640, 480)), LABORATORY);
    let odd = Region::from_shares(shares, PictureSize::new(1920, 720));
    assert_eq!((odd.a_px, odd.b_px), (576.0, 180.0));
}

#[test]
fn a_percept_shows_distance_and_direction() {
    let percept = Percept::new(ImagePoint { x: -30.0, y: 40.0 }, LABORATORY);
    assert_eq!(percept.r_px, 50.0);
    assert!((percept.direction.degrees() - 126.869_897_645_844).abs() < 1e-9);
}

#[test]
fn a_position_that_is_not_a_number_moves_nothing() {
    assert!(command_at(f64::NAN, 0.0).is_rest());
    assert!(command_at(0.0, f64::NAN).is_rest());
}

proptest! {
    #[test]
    fn exactly_one_axis_turns_outside_and_none_inside(x in -400.0..400.0f64, y in -300.0..300.0f64) {
        let command = command_at(x, y);
        let outside = LABORATORY.p(ImagePoint { x, y }) > 1.0;
        let turning = usize::from(!command.pan.is_zero()) + usize::from(!command.tilt.is_zero());
        prop_assert_eq!(turning, usize::from(outside));
    }

    #[test]
    fn the_camera_turns_towards_the_target(x in -400.0..400.0f64, y in -300.0..300.0f64) {
        let command = command_at(x, y);
        prop_assert!(command.pan.radians_per_second() * x >= 0.0);
        prop_assert!(command.tilt.radians_per_second() * y >= 0.0);
    }

    #[test]
    fn mirrored_targets_lie_in_mirrored_sectors_off_the_diagonals(x in 0.1..400.0f64, y in -300.0..300.0f64) {
        prop_assume!((x - y.abs()).abs() > 1e-9);
        let mirrored = match Sector::from_point(ImagePoint { x, y }) {
            Sector::Right => Sector::Left,
            other => other,
        };
        prop_assert_eq!(Sector::from_point(ImagePoint { x: -x, y }), mirrored);
    }
}
