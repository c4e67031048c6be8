//! The intermittent mode: the course of a movement, its ramps and its corrections.

use barrelman_control::{CameraLaw, IntermittentTuning, OptimalLaw};
use barrelman_vocab::OptimalMode::Intermittent;
use barrelman_vocab::{CameraCommand, Framed, ImagePoint, Timestamp, VehicleProfile};

use crate::optimal::{STEP_S, follow, law, rates, step};

/// The steps of the first movement.
fn first_movement(commands: &[CameraCommand]) -> &[CameraCommand] {
    let start = commands.iter().position(|command| !command.is_rest()).expect("a movement");
    let duration = commands[start..].iter().position(|command| command.is_rest()).expect("a rest");
    &commands[start..start + duration]
}

/// The commands for a target that is seen at these places, one for each picture.
fn answers(profile: &VehicleProfile, places: impl Iterator<Item = ImagePoint>) -> Vec<CameraCommand> {
    let mut law = law(Intermittent, profile);
    let now = |k: usize| Timestamp::from_secs_f64(1.0 + k as f64 * STEP_S);
    places.enumerate().map(|(k, place)| step(&mut law, profile, place, now(k))).collect()
}

#[test]
fn a_steady_target_is_answered_by_movements_of_one_rate_with_rests_between() {
    let course = follow(Intermittent, &VehicleProfile::fotokite_pro(), 0.0, 0.1, 30.0);
    let commands: Vec<CameraCommand> = course.iter().map(|(_, command)| *command).collect();
    let movement = first_movement(&commands);
    let pans: Vec<f64> = movement.iter().map(|command| rates(*command)[0]).collect();
    assert!(pans.iter().all(|pan| pan.to_bits() == pans[0].to_bits()), "{pans:?}");
    let resting = commands.iter().filter(|command| command.is_rest()).count();
    assert!(2 * resting > commands.len(), "rests in {resting} of {} steps", commands.len());
}

#[test]
fn the_axis_with_the_short_lag_is_ramped_and_the_slow_one_is_not() {
    let profile = VehicleProfile::fotokite_pro();
    let upwards = (0..60).map(|k| ImagePoint { x: 0.0, y: 3.0 * f64::from(k) });
    let tilts: Vec<f64> = answers(&profile, upwards).into_iter().map(|command| rates(command)[1]).collect();
    let largest = tilts.iter().copied().fold(0.0, f64::max);
    let rises: Vec<f64> = tilts.windows(2).map(|pair| pair[1] - pair[0]).filter(|rise| *rise > 0.0).collect();
    assert!(rises.len() >= 4 && rises.iter().all(|rise| *rise < 0.4 * largest), "{rises:?}");

    let sideways = (0..60).map(|k| ImagePoint { x: 5.0 * f64::from(k), y: 0.0 });
    let pans: Vec<f64> = answers(&profile, sideways).into_iter().map(|command| rates(command)[0]).collect();
    let first = pans.iter().copied().find(|pan| *pan > 0.0).expect("a movement");
    assert!(first > 0.25, "{first} rad/s at once");
}

#[test]
fn an_axis_at_rest_has_a_rate_of_positive_zero() {
    let profile = VehicleProfile::fotokite_pro();
    let out_and_back = (0..240_u32).map(|k| {
        let away = 1.5 * f64::from(if k < 120 { k } else { 240 - k });
        ImagePoint { x: -away, y: -away }
    });
    let commands = answers(&profile, out_and_back);
    assert!(commands.iter().any(|command| !command.is_rest()));
    for rate in commands.into_iter().flat_map(rates).filter(|rate| *rate == 0.0) {
        assert!(rate.is_sign_positive(), "{rate}");
    }
}

#[test]
fn a_movement_that_would_miss_gets_new_rates() {
    // The target leaves slowly, and runs away when the camera has begun to turn.
    let profile = VehicleProfile::fotokite_pro();
    let runs_away = (0..80_u32).map(|k| {
        let fast = f64::from(k.saturating_sub(40));
        ImagePoint { x: 150.0 + 1.3 * f64::from(k) + 6.0 * fast, y: 0.0 }
    });
    let pans: Vec<f64> = answers(&profile, runs_away).into_iter().map(|command| rates(command)[0]).collect();
    let first = pans.iter().copied().find(|pan| *pan > 0.0).expect("a movement");
    let largest = pans.iter().copied().fold(0.0, f64::max);
    assert!(largest > 1.1 * first, "{first} rad/s, later {largest}");
}

/// How far the camera of the profile has panned after a target was at these azimuths, one for each picture:
/// dead times, then the lag. The camera is level.
fn final_pan(law: &mut CameraLaw, profile: &VehicleProfile, azimuths: impl Iterator<Item = f64>) -> f64 {
    let focal_px = profile.camera.focal_share * 640.0;
    let (mut pan, mut rate, mut sent) = (0.0, 0.0, Vec::new());
    let lag_s = profile.camera.pan.lag.as_secs_f64();
    let mut seen = vec![0.0; 4];
    for (k, azimuth) in azimuths.enumerate() {
        let place = ImagePoint { x: focal_px * libm::tan(azimuth - seen[k]), y: 0.0 };
        let now = Timestamp::from_secs_f64(1.0 + k as f64 * STEP_S);
        sent.push(rates(step(law, profile, place, now))[0]);
        let asked = if k >= 12 && sent[k - 6] == 0.0 { sent[k - 12] } else { sent[k.saturating_sub(6)] };
        let effective = if k < 6 { 0.0 } else { asked };
        rate += (effective - rate) * (1.0 - libm::exp(-STEP_S / lag_s));
        pan += rate * STEP_S;
        seen.push(pan);
    }
    pan
}

/// The profile with a level camera.
fn level_profile() -> VehicleProfile {
    let mut profile = VehicleProfile::fotokite_pro();
    profile.camera.initial_tilt = barrelman_vocab::Angle::ZERO;
    profile
}

#[test]
fn a_movement_does_not_end_beyond_the_middle() {
    // A target that stands outside is brought in, and not to the other side.
    let profile = level_profile();
    let focal_px = profile.camera.focal_share * 640.0;
    for x in [210.0, -250.0] {
        let azimuth = libm::atan(x / focal_px);
        let pan = final_pan(&mut law(Intermittent, &profile), &profile, (0..240).map(|_| azimuth));
        let end = focal_px * libm::tan(azimuth - pan);
        assert!(end * x > 0.0 && end.abs() < 0.9 * 192.0, "from {x} px to {end} px");
    }
}

#[test]
fn the_camera_turns_less_after_a_target_that_is_expected_back() {
    // Twenty seconds in the middle, then away at 0.1 rad/s until the target is outside, and no farther.
    let profile = level_profile();
    let azimuths = (0..900_u32).map(|k| (0.1 * STEP_S * f64::from(k.saturating_sub(600))).min(0.6));
    let pan_with = |return_time_s: f64| {
        let tuning = IntermittentTuning { return_time_s, ..IntermittentTuning::DEFAULT };
        let law = Box::new(OptimalLaw::with_tuning(tuning, Framed::Boat, &profile));
        final_pan(&mut CameraLaw::from_law(law, &profile), &profile, azimuths.clone())
    };
    let (expected_back, never_back) = (pan_with(IntermittentTuning::DEFAULT.return_time_s), pan_with(1e9));
    assert!(0.0 < expected_back && expected_back < 0.9 * never_back, "{expected_back} rad, {never_back} rad");
}
