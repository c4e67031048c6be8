//! The vehicle boundary: from camera commands to a vehicle's own rates and back.

use barrelman_vocab::profile::{AxisRates, AxisSigns, Sign};
use barrelman_vocab::{AngularRate, CameraCommand, VehicleProfile, VehicleRates};
use proptest::prelude::*;

fn rate(rad_per_s: f64) -> AngularRate {
    AngularRate::from_radians_per_second(rad_per_s)
}

fn command(pan: f64, tilt: f64) -> CameraCommand {
    CameraCommand { pan: rate(pan), tilt: rate(tilt) }
}

fn rates(yaw: f64, pitch: f64) -> VehicleRates {
    VehicleRates { yaw: rate(yaw), pitch: rate(pitch) }
}

fn signed(yaw: Sign, pitch: Sign) -> VehicleProfile {
    VehicleProfile { signs: AxisSigns { yaw, pitch }, ..VehicleProfile::fotokite_pro() }
}

#[test]
fn a_fotokite_pro_counts_both_axes_the_other_way_within_its_limits() {
    let check = |(pan, tilt), (yaw, pitch)| {
        let out = VehicleProfile::fotokite_pro().to_vehicle(command(pan, tilt));
        assert_eq!(out, rates(yaw, pitch), "pan {pan}, tilt {tilt}");
    };
    check((0.3, 0.0), (-0.3, 0.0));
    check((-0.3, 0.0), (0.3, 0.0));
    check((0.0, 0.3), (0.0, -0.3));
    check((0.0, -0.3), (0.0, 0.3));
    check((0.5, 0.5), (-0.4, -0.3));
    check((-9.0, -9.0), (0.4, 0.3));
    check((f64::NAN, f64::NAN), (0.0, 0.0));
    check((f64::INFINITY, f64::NEG_INFINITY), (-0.4, 0.3));
}

#[test]
fn each_axis_has_its_own_sign() {
    let check = |yaw, pitch, expected| {
        let profile = signed(yaw, pitch);
        assert_eq!(profile.to_vehicle(command(0.2, 0.1)), expected);
        assert_eq!(profile.from_vehicle(expected), command(0.2, 0.1));
    };
    check(Sign::Same, Sign::Same, rates(0.2, 0.1));
    check(Sign::Opposite, Sign::Same, rates(-0.2, 0.1));
    check(Sign::Same, Sign::Opposite, rates(0.2, -0.1));
    check(Sign::Opposite, Sign::Opposite, rates(-0.2, -0.1));
}

#[test]
fn a_vehicle_whose_limit_is_no_number_is_not_moved() {
    let nan = AxisRates { pan: rate(f64::NAN), tilt: rate(f64::NAN) };
    let profile = VehicleProfile { limits: nan, ..VehicleProfile::fotokite_pro() };
    assert_eq!(profile.to_vehicle(command(0.3, -0.3)), VehicleRates::REST);
}

fn any_sign() -> impl Strategy<Value = Sign> {
    prop_oneof![Just(Sign::Same), Just(Sign::Opposite)]
}

fn any_rate() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -0.5..0.5, 1 => any::<f64>(), 1 => Just(0.0), 1 => Just(-0.0)]
}

fn has_no_negative_zero(rates: [AngularRate; 2]) -> bool {
    rates.iter().all(|rate| rate.radians_per_second().to_bits() != (-0.0_f64).to_bits())
}

proptest! {
    #[test]
    fn what_goes_out_comes_back_in_within_the_limits(
        yaw in any_sign(), pitch in any_sign(), pan in -0.4..0.4, tilt in -0.3..0.3,
    ) {
        let profile = signed(yaw, pitch);
        prop_assert_eq!(profile.from_vehicle(profile.to_vehicle(command(pan, tilt))), command(pan, tilt));
    }

    #[test]
    fn no_vehicle_is_sent_a_negative_zero(
        yaw in any_sign(), pitch in any_sign(), pan in any_rate(), tilt in any_rate(), limit in any_rate(),
    ) {
        let limits = AxisRates { pan: rate(limit), tilt: rate(limit) };
        let profile = VehicleProfile { limits, ..signed(yaw, pitch) };
        let out = profile.to_vehicle(command(pan, tilt));
        prop_assert!(has_no_negative_zero([out.yaw, out.pitch]), "{out:?}");
        let back = profile.from_vehicle(rates(pan, tilt));
        prop_assert!(has_no_negative_zero([back.pan, back.tilt]), "{back:?}");
    }
}
