//! Angular rates: limits, and zeros without a sign.

use barrelman_vocab::{Angle, AngularRate, CameraCommand, VehicleProfile};
use proptest::prelude::*;

fn rate(rad_per_s: f64) -> AngularRate {
    AngularRate::from_radians_per_second(rad_per_s)
}

#[test]
fn a_rate_is_held_within_its_limit_on_both_sides() {
    let check = |asked: f64, limit: f64, expected: f64| {
        let clamped = rate(asked).clamped(rate(limit)).radians_per_second();
        assert_eq!(clamped, expected, "{asked} within {limit}");
    };
    check(0.2, 0.3, 0.2);
    check(0.4, 0.3, 0.3);
    check(-0.4, 0.3, -0.3);
    check(-0.4, -0.3, -0.3);
    check(0.4, 0.0, 0.0);
    check(f64::INFINITY, 0.3, 0.3);
    check(f64::NEG_INFINITY, 0.3, -0.3);
    check(f64::MIN_POSITIVE, 0.3, f64::MIN_POSITIVE);
}

#[test]
fn what_is_not_a_number_moves_nothing() {
    assert_eq!(rate(f64::NAN).clamped(rate(0.3)), AngularRate::ZERO);
    assert_eq!(rate(0.3).clamped(rate(f64::NAN)), AngularRate::ZERO);
    assert_eq!(rate(f64::NAN).clamped(rate(f64::NAN)), AngularRate::ZERO);
}

#[test]
fn the_opposite_of_zero_has_no_sign() {
    for zero in [0.0, -0.0] {
        assert_eq!((-rate(zero)).radians_per_second().to_bits(), 0.0_f64.to_bits());
    }
    assert_eq!((-rate(0.3)).radians_per_second(), -0.3);
}

#[test]
fn negative_zero_is_rest() {
    assert!(rate(-0.0).is_zero());
    assert!(CameraCommand::turning(rate(-0.0), rate(0.0)).is_rest());
    assert!(!CameraCommand::turning(rate(0.0), rate(1e-300)).is_rest());
    assert!(CameraCommand::REST.is_rest());
}

#[test]
fn degrees_and_radians_agree() {
    assert_eq!(Angle::from_degrees(180.0).radians(), core::f64::consts::PI);
    assert_eq!(Angle::from_radians(core::f64::consts::FRAC_PI_2).degrees(), 90.0);
}

proptest! {
    #[test]
    fn no_rate_passes_its_limit(asked in any::<f64>(), limit in any::<f64>()) {
        let clamped = rate(asked).clamped(rate(limit)).radians_per_second();
        prop_assert!(clamped.is_finite() || limit.is_infinite());
        prop_assert!(clamped == 0.0 || clamped.abs() <= limit.abs());
    }
}

#[test]
fn what_was_sent_has_the_size_of_the_rates_and_the_sense_of_the_command() {
    let profile = VehicleProfile::fotokite_pro();
    for (pan, tilt, expected) in [
        (0.3, -0.2, (0.3, -0.2)),
        (-0.3, 0.2, (-0.3, 0.2)),
        (0.0, 0.0, (0.0, 0.0)),
        // Beyond the vehicle's limits, 0.4 and 0.3 rad/s.
        (0.9, -0.9, (0.4, -0.3)),
    ] {
        let command = CameraCommand::turning(rate(pan), rate(tilt));
        let sent = profile.to_vehicle(command).in_the_senses_of(command);
        let wanted = CameraCommand::turning(rate(expected.0), rate(expected.1));
        assert_eq!(sent, wanted, "{pan}, {tilt}");
        assert_eq!(sent, profile.from_vehicle(profile.to_vehicle(command)), "{pan}, {tilt}");
    }
}
