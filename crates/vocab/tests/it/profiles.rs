//! The vehicle boundary: from camera commands to a vehicle's own rates and back.

use barrelman_vocab::profile::{AxisRates, AxisSigns, Sign};
use barrelman_vocab::{Angle, AngularRate, CameraCommand, VehicleProfile, VehicleRates};
use proptest::prelude::*;

fn rate(rad_per_s: f64) -> AngularRate {
    AngularRate::from_radians_per_second(rad_per_s)
}

fn command(pan: f64, tilt: f64) -> CameraCommand {
    CameraCommand::turning(rate(pan), rate(tilt))
}

fn rates(yaw: f64, pitch: f64) -> VehicleRates {
    VehicleRates::turning(rate(yaw), rate(pitch))
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

/// A profile with least rates of 0.04 and 0.06 rad/s, limits of 0.4 and 0.3 rad/s, and end stops at -90 and
/// 10 degrees.
fn with_min_rates() -> VehicleProfile {
    let mut profile = VehicleProfile::fotokite_pro();
    (profile.camera.pan.min_rate, profile.camera.tilt.min_rate) = (rate(0.04), rate(0.06));
    profile
}

#[test]
fn a_rate_below_the_least_is_the_least_or_zero() {
    let check = |asked, expected| {
        let (pan, tilt) = expected;
        assert_eq!(with_min_rates().executable(command(asked, asked), None), command(pan, tilt), "{asked}");
        let negative = with_min_rates().executable(command(-asked, -asked), None);
        assert_eq!(negative, command(-pan, -tilt), "-{asked}");
        assert_eq!(with_min_rates().to_vehicle(command(asked, asked)), rates(-pan, -tilt), "at the boundary");
    };
    check(0.0, (0.0, 0.0));
    check(1e-9, (0.0, 0.0));
    check(0.019, (0.0, 0.0));
    check(0.020, (0.04, 0.0));
    check(0.029, (0.04, 0.0));
    check(0.030, (0.04, 0.06));
    check(0.05, (0.05, 0.06));
    check(0.06, (0.06, 0.06));
    check(0.35, (0.35, 0.3));
    check(f64::INFINITY, (0.4, 0.3));
}

#[test]
fn an_axis_whose_least_rate_is_above_its_limit_does_not_turn() {
    let limits = AxisRates { pan: rate(0.03), tilt: rate(0.3) };
    let profile = VehicleProfile { limits, ..with_min_rates() };
    assert_eq!(profile.executable(command(0.3, 0.1), None), command(0.0, 0.1));
}

#[test]
fn no_rate_leads_beyond_an_end_stop() {
    let check = |tilt_deg, asked, expected| {
        let tilt = Some(Angle::from_degrees(tilt_deg));
        let executable = VehicleProfile::fotokite_pro().executable(command(0.2, asked), tilt);
        assert_eq!(executable, command(0.2, expected), "at {tilt_deg} degrees");
    };
    check(9.9, 0.1, 0.1);
    check(10.0, 0.1, 0.0);
    check(10.0, -0.1, -0.1);
    check(30.0, 0.1, 0.0);
    check(-89.9, -0.1, -0.1);
    check(-90.0, -0.1, 0.0);
    check(-95.0, 0.1, 0.1);
    check(f64::NAN, 0.1, 0.1);
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
    fn what_is_executable_is_executed_unchanged(pan in any_rate(), tilt in any_rate(), at in -2.0..1.0) {
        let (profile, at) = (with_min_rates(), Some(Angle::from_radians(at)));
        let executable = profile.executable(command(pan, tilt), at);
        prop_assert_eq!(profile.executable(executable, at), executable);
        for (rate, limit, min) in [(executable.pan, 0.4, 0.04), (executable.tilt, 0.3, 0.06)] {
            let size = rate.abs().radians_per_second();
            prop_assert!(size == 0.0 || (min..=limit).contains(&size), "{executable:?}");
        }
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
