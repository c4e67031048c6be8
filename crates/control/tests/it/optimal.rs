//! The optimal law, alone and in a loop with a simulated camera.

use core::time::Duration;

use barrelman_control::optimal::{OptimalLaw, OptimalSettings, Tuning};
use barrelman_control::{CameraLaw, LawInput, LawSettings, Percept, Region};
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, PictureSize, Timestamp, VehicleProfile};
use barrelman_vocab::{Framed, LawId, OptimalMode};
use proptest::prelude::*;

const PICTURE: PictureSize = PictureSize::new(640, 480);
pub(crate) const STEP_S: f64 = 1.0 / 30.0;
const MODES: [OptimalMode; 4] =
    [OptimalMode::MinimumEnergy, OptimalMode::TimeFuel, OptimalMode::Eco, OptimalMode::Intermittent];

pub(crate) fn law(mode: OptimalMode, profile: &VehicleProfile) -> CameraLaw {
    CameraLaw::new(LawSettings::Optimal(OptimalSettings::new(mode)), profile)
}

pub(crate) fn rates(command: CameraCommand) -> [f64; 2] {
    [command.pan.radians_per_second(), command.tilt.radians_per_second()]
}

/// Runs one step with a measurement that is 0.1 s old, and returns the command.
pub(crate) fn step(
    law: &mut CameraLaw,
    profile: &VehicleProfile,
    position: ImagePoint,
    now: Timestamp,
) -> CameraCommand {
    let region = Region::from_shares(profile.region, PICTURE);
    let percept = Percept::new(position, region);
    let captured = now.minus(Duration::from_millis(100));
    let command = law.command(&LawInput::measured(&percept, region, PICTURE, captured, now));
    law.on_command_applied(command, now);
    command
}

/// Runs the law with a camera without lag and a target with a constant bearing rate for `seconds`. Returns
/// the target's x in the picture and the command of each step.
pub(crate) fn follow(
    mode: OptimalMode,
    profile: &VehicleProfile,
    start_px: f64,
    speed: f64,
    seconds: f64,
) -> Vec<(f64, CameraCommand)> {
    let focal_px = profile.camera.focal_share * f64::from(PICTURE.width);
    let mut law = law(mode, profile);
    let mut pan = 0.0;
    let mut pans = vec![0.0; 4];
    let mut course = Vec::new();
    for k in 0..(seconds / STEP_S) as usize {
        let t = k as f64 * STEP_S;
        // The camera looks horizontally, so that pan equals azimuth. The measurement is 100 ms old.
        let seen_pan = pans[pans.len() - 4];
        let azimuth = libm::atan(start_px / focal_px) + speed * (t - 0.1) - seen_pan;
        let position = ImagePoint { x: focal_px * libm::tan(azimuth), y: 0.0 };
        let command = step(&mut law, profile, position, Timestamp::from_secs_f64(1.0 + t));
        pan += STEP_S * rates(command)[0];
        pans.push(pan);
        course.push((position.x, command));
    }
    course
}

/// A vehicle without dead time and lag that looks horizontally.
fn vehicle_without_lag() -> VehicleProfile {
    let mut profile = VehicleProfile::fotokite_pro();
    for axis in [&mut profile.camera.pan, &mut profile.camera.tilt] {
        (axis.start_dead_time, axis.stop_dead_time, axis.lag) =
            (Duration::ZERO, Duration::ZERO, Duration::ZERO);
    }
    profile.camera.initial_tilt = barrelman_vocab::Angle::ZERO;
    profile
}

#[test]
fn a_target_that_stands_inside_moves_nothing() {
    for mode in MODES {
        let profile = VehicleProfile::fotokite_pro();
        let mut law = law(mode, &profile);
        for k in 0..300 {
            let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
            let command = step(&mut law, &profile, ImagePoint { x: 120.0, y: -60.0 }, now);
            assert_eq!(command, CameraCommand::REST, "{mode:?} at step {k}");
        }
    }
}

#[test]
fn a_target_that_leaves_is_kept_and_then_the_camera_rests() {
    for mode in MODES {
        let course = follow(mode, &vehicle_without_lag(), 0.0, 0.12, 20.0);
        let edge = 0.6 * 320.0;
        let farthest = course.iter().map(|(x, _)| x.abs()).fold(0.0, f64::max);
        assert!(farthest < 1.1 * edge, "{mode:?}: {farthest} px");
        let resting = course.iter().filter(|(_, command)| command.is_rest()).count();
        assert!(resting * 8 > course.len(), "{mode:?}: rests in {resting} of {} steps", course.len());
        let (_, last) = course.iter().rev().find(|(_, command)| !command.is_rest()).unwrap();
        assert!(last.pan > AngularRate::ZERO, "{mode:?}");
    }
}

#[test]
fn a_target_found_outside_is_fetched_within_a_few_horizons_and_then_the_camera_rests() {
    for mode in MODES {
        let course = follow(mode, &vehicle_without_lag(), 260.0, 0.0, 45.0);
        assert!(course[0].0 > 250.0);
        let (x, _) = course[(8.0 / STEP_S) as usize];
        assert!(x.abs() < 192.0, "{mode:?}: {x} px after 8 s");
        let (x, command) = *course.last().unwrap();
        assert!(x.abs() < 192.0 && command.is_rest(), "{mode:?}: {x} px, {command:?}");
    }
}

#[test]
fn looking_down_steeply_pan_is_spared() {
    let first = |down: f64, steep_view_gain: f64| {
        let mut profile = VehicleProfile::fotokite_pro();
        profile.camera.initial_tilt = barrelman_vocab::Angle::from_degrees(-down);
        let tuning = Tuning { steep_view_gain, horizon_s: 3.0, ..Tuning::MINIMUM_ENERGY };
        let mut law =
            CameraLaw::from_law(Box::new(OptimalLaw::with_tuning(tuning, Framed::Boat, &profile)), &profile);
        rates(step(&mut law, &profile, ImagePoint { x: 190.0, y: 0.0 }, Timestamp::from_secs_f64(1.0)))[0]
    };
    assert!((first(0.0, 1.0) - first(0.0, 0.0)).abs() < 1e-3, "looking level nothing is to be spared");
    assert!(first(60.0, 1.0) < 0.8 * first(60.0, 0.0), "{} {}", first(60.0, 1.0), first(60.0, 0.0));
    assert!(first(85.0, 1.0) > 0.0, "it does not give up");
}

#[test]
fn both_axes_move_at_once() {
    let profile = VehicleProfile::fotokite_pro();
    let mut law = law(OptimalMode::MinimumEnergy, &profile);
    let mut both = false;
    for k in 0..30 {
        let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
        let [pan, tilt] = rates(step(&mut law, &profile, ImagePoint { x: 200.0, y: 110.0 }, now));
        assert!(pan >= 0.0 && tilt >= 0.0, "towards the target");
        both |= pan > 0.0 && tilt > 0.0;
    }
    assert!(both);
}

#[test]
fn a_vehicle_s_least_rate_is_respected() {
    let mut profile = VehicleProfile::fotokite_pro();
    let min_rate = 0.2;
    for axis in [&mut profile.camera.pan, &mut profile.camera.tilt] {
        axis.min_rate = AngularRate::from_radians_per_second(min_rate);
    }
    let mut law = law(OptimalMode::MinimumEnergy, &profile);
    let mut moved = false;
    for k in 0..600 {
        let t = f64::from(k) * STEP_S;
        let position = ImagePoint { x: 260.0 * libm::sin(0.7 * t), y: 130.0 * libm::cos(0.4 * t) };
        for rate in rates(step(&mut law, &profile, position, Timestamp::from_secs_f64(1.0 + t))) {
            assert!(rate == 0.0 || rate.abs() >= min_rate - 1e-12, "{rate} rad/s");
            moved |= rate != 0.0;
        }
    }
    assert!(moved);
}

#[test]
fn a_vehicle_that_cannot_creep_fetches_a_slow_target_to_the_middle_all_the_same() {
    let mut profile = vehicle_without_lag();
    for axis in [&mut profile.camera.pan, &mut profile.camera.tilt] {
        axis.min_rate = AngularRate::from_radians_per_second(0.035);
    }
    // The target moves by 1.2 rad; the region extends 0.5 rad to each side.
    let course = follow(OptimalMode::MinimumEnergy, &profile, 0.0, 0.01, 120.0);
    let moving: Vec<bool> = course.iter().map(|(_, command)| !command.is_rest()).collect();
    let starts = moving.windows(2).filter(|pair| !pair[0] && pair[1]).count();
    let rests = course.windows(2).filter(|pair| !pair[0].1.is_rest() && pair[1].1.is_rest());
    assert!((1..=4).contains(&starts), "{starts} movements");
    for (at, (x, _)) in rests.map(|pair| pair[1]).enumerate() {
        assert!(x.abs() < 40.0, "movement {at} ended {x} px from the middle");
    }
}

#[test]
fn a_camera_that_zoomed_is_moved_as_one_that_was_built_so() {
    let zoomed = vehicle_without_lag();
    let mut built = zoomed.clone();
    built.camera.focal_share = 2.0;
    let (mut reported, mut built_law) =
        (law(OptimalMode::MinimumEnergy, &zoomed), law(OptimalMode::MinimumEnergy, &built));
    let field_of_view = barrelman_vocab::Angle::from_radians(2.0 * libm::atan(0.25));
    reported.on_field_of_view_report(field_of_view, Timestamp::from_secs_f64(0.5));
    for k in 0..60 {
        let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
        let position = ImagePoint { x: 4.0 * f64::from(k), y: -f64::from(k) };
        let [a, b] = [(&mut reported, &zoomed), (&mut built_law, &built)]
            .map(|(law, profile)| rates(step(law, profile, position, now)));
        assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9, "{k}: {a:?} {b:?}");
        assert!(k < 55 || a[0] > 0.0, "{k}: it leaves");
    }
}

#[test]
fn a_zoom_under_way_is_no_motion_of_the_target() {
    // A stationary target near the centre, well inside the region at every zoom.
    let vehicle = vehicle_without_lag();
    let mut law = law(OptimalMode::MinimumEnergy, &vehicle);
    for k in 0..90 {
        let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
        let share = if k < 30 { vehicle.camera.focal_share } else { 2.0 * vehicle.camera.focal_share };
        let field_of_view = barrelman_vocab::Angle::from_radians(2.0 * libm::atan(0.5 / share));
        law.on_field_of_view_report(field_of_view, now.minus(Duration::from_millis(100)));
        let position = ImagePoint { x: 640.0 * share * libm::tan(0.12), y: 0.0 };
        assert_eq!(rates(step(&mut law, &vehicle, position, now)), [0.0, 0.0], "{k}");
    }
}

#[test]
fn what_the_tracker_expects_is_no_look() {
    // A target that leaves to the right, and a tracker that then predicts it on either side.
    let profile = VehicleProfile::fotokite_pro();
    let commands = [300.0, -300.0].map(|expected| {
        let mut law = law(OptimalMode::MinimumEnergy, &profile);
        let mut commands = Vec::new();
        for k in 0..30 {
            let t = f64::from(k) * STEP_S;
            let (x, seen) = if k < 24 { (100.0 + 120.0 * t, true) } else { (expected, false) };
            let now = Timestamp::from_secs_f64(1.0 + t);
            let percept =
                Percept::new(ImagePoint { x, y: 0.0 }, Region::from_shares(profile.region, PICTURE));
            let captured = now.minus(Duration::from_millis(100));
            let region = Region::from_shares(profile.region, PICTURE);
            let input = LawInput {
                percept: &percept,
                region,
                destination: None,
                picture: PICTURE,
                captured,
                is_measured: seen,
                now,
            };
            let command = law.command(&input);
            law.on_command_applied(command, now);
            commands.push(command);
        }
        commands
    });
    assert_eq!(commands[0], commands[1]);
    assert!(rates(commands[0][29])[0] > 0.0, "it is still followed");
}

#[test]
fn whether_it_moves_is_judged_by_what_is_in_force() {
    // Disengaged: the law's commands are never in force. The target leaves, returns, and rests well inside
    // the region.
    for mode in MODES {
        let profile = VehicleProfile::fotokite_pro();
        let mut law = law(mode, &profile);
        let mut last = CameraCommand::REST;
        let mut asked_to_move = false;
        for k in 0..300 {
            let t = f64::from(k) * STEP_S;
            let x = 115.0 + 115.0 * libm::sin((1.2 * t).min(core::f64::consts::PI));
            let now = Timestamp::from_secs_f64(1.0 + t);
            last = step(&mut law, &profile, ImagePoint { x, y: 0.0 }, now);
            law.on_command_applied(CameraCommand::REST, now);
            asked_to_move |= !last.is_rest();
        }
        assert!(asked_to_move, "{mode:?}");
        assert!(last.is_rest(), "{mode:?}: {last:?}");
    }
}

#[test]
fn an_end_stop_ends_the_motion() {
    for mode in MODES {
        let profile = VehicleProfile::fotokite_pro();
        let camera = profile.camera;
        let mut law = law(mode, &profile);
        let mut tilt = camera.initial_tilt.radians();
        let (mut moved, mut last) = (false, CameraCommand::REST);
        // A stationary target above the upper end stop, and a camera without lag.
        for k in 0..900 {
            let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
            let focal_px = camera.focal_share * f64::from(PICTURE.width);
            let y = focal_px * libm::tan(0.6 - tilt);
            last = step(&mut law, &profile, ImagePoint { x: 0.0, y }, now);
            tilt = (tilt + STEP_S * rates(last)[1]).min(camera.tilt_stops.1.radians());
            moved |= !last.is_rest();
        }
        assert!(moved && last.is_rest(), "{mode:?}: {last:?} at {tilt}");
        assert!(camera.tilt_stops.1.radians() - tilt < 0.05, "{mode:?}: it goes as far as it can, {tilt}");
    }
}

#[test]
fn a_pause_between_pictures_is_counted() {
    // The camera turns while no picture arrives for 0.5 s. The result must be the same as with intermediate
    // updates of the camera model.
    let profile = VehicleProfile::fotokite_pro();
    let commands = [1, 15].map(|parts| {
        let mut law = law(OptimalMode::MinimumEnergy, &profile);
        let mut command = CameraCommand::REST;
        let mut now = Timestamp::from_secs_f64(1.0);
        for k in 0..30 {
            now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
            command = step(&mut law, &profile, ImagePoint { x: 150.0 + 4.0 * f64::from(k), y: 0.0 }, now);
        }
        assert!(!command.is_rest());
        for _ in 1..parts {
            now = now.plus(Duration::from_millis(500 / parts));
            law.on_command_applied(command, now);
        }
        let now = Timestamp::from_secs_f64(1.0 + 29.0 * STEP_S + 0.5);
        rates(step(&mut law, &profile, ImagePoint { x: 200.0, y: 0.0 }, now))
    });
    // The history is interpolated by a cubic, hence the tolerance.
    assert!((commands[0][0] - commands[1][0]).abs() < 1e-4, "{commands:?}");
}

#[test]
fn a_least_rate_above_the_mode_s_largest_is_turned_at() {
    let mut profile = VehicleProfile::fotokite_pro();
    for axis in [&mut profile.camera.pan, &mut profile.camera.tilt] {
        axis.min_rate = AngularRate::from_radians_per_second(0.38);
    }
    let mut law = law(OptimalMode::MinimumEnergy, &profile);
    let [pan, _] =
        rates(step(&mut law, &profile, ImagePoint { x: 300.0, y: 0.0 }, Timestamp::from_secs_f64(1.0)));
    assert!(pan >= 0.38, "{pan} rad/s");
}

#[test]
fn a_longer_horizon_is_lazier() {
    let profile = VehicleProfile::fotokite_pro();
    let effort = |horizon_s: f64| {
        let settings = OptimalSettings {
            horizon_s: Some(horizon_s),
            ..OptimalSettings::new(OptimalMode::MinimumEnergy)
        };
        let mut law = CameraLaw::new(LawSettings::Optimal(settings), &profile);
        let [pan, _] =
            rates(step(&mut law, &profile, ImagePoint { x: 190.0, y: 0.0 }, Timestamp::from_secs_f64(1.0)));
        pan
    };
    let (tight, lazy) = (effort(1.5), effort(4.0));
    assert!(tight > lazy && lazy > 0.0, "{tight} {lazy}");
}

#[test]
fn after_a_gap_it_begins_anew() {
    let profile = VehicleProfile::fotokite_pro();
    let mut law = law(OptimalMode::MinimumEnergy, &profile);
    // The target leaves the picture to the right, is not seen for a second, and then rests at the centre.
    for k in 0..20 {
        let position = ImagePoint { x: 10.0 * f64::from(k), y: 0.0 };
        step(&mut law, &profile, position, Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S));
    }
    law.on_command_applied(CameraCommand::REST, Timestamp::from_secs_f64(1.9));
    let command = step(&mut law, &profile, ImagePoint { x: 0.0, y: 0.0 }, Timestamp::from_secs_f64(3.0));
    assert_eq!(command, CameraCommand::REST);
}

/// A sequence of arbitrary measurements: x, y, and milliseconds since the previous one.
fn any_measurements() -> impl Strategy<Value = Vec<(f64, f64, u16)>> {
    let coordinate = prop_oneof![4 => -400.0_f64..400.0, 1 => prop::num::f64::ANY];
    prop::collection::vec(
        (coordinate.clone(), coordinate, prop_oneof![8 => 20_u16..50, 1 => any::<u16>()]),
        1..120,
    )
}

proptest! {
    #[test]
    fn whatever_is_seen_the_rates_are_within_the_limits(measurements in any_measurements(), mode in 0_usize..3) {
        let profile = VehicleProfile::fotokite_pro();
        let mut law = law(MODES[mode], &profile);
        let mut now_ms = 1_000_u64;
        for (x, y, span_ms) in measurements {
            now_ms += u64::from(span_ms);
            let now = Timestamp::from_nanos(now_ms * 1_000_000);
            let [pan, tilt] = rates(step(&mut law, &profile, ImagePoint { x, y }, now));
            prop_assert!(pan.abs() <= profile.limits.pan.radians_per_second(), "{} rad/s", pan);
            prop_assert!(tilt.abs() <= profile.limits.tilt.radians_per_second(), "{} rad/s", tilt);
        }
    }

    #[test]
    fn mirrored_left_to_right_it_pans_the_other_way(measurements in any_measurements(), mode in 0_usize..3) {
        let profile = VehicleProfile::fotokite_pro();
        let (mut law, mut mirrored) = (law(MODES[mode], &profile), law(MODES[mode], &profile));
        let mut now_ms = 1_000_u64;
        for (x, y, span_ms) in measurements {
            now_ms += u64::from(span_ms);
            let now = Timestamp::from_nanos(now_ms * 1_000_000);
            let [pan, tilt] = rates(step(&mut law, &profile, ImagePoint { x, y }, now));
            let [other_pan, other_tilt] = rates(step(&mut mirrored, &profile, ImagePoint { x: -x, y }, now));
            prop_assert!((pan + other_pan).abs() < 1e-9, "{} {}", pan, other_pan);
            prop_assert!((tilt - other_tilt).abs() < 1e-9, "{} {}", tilt, other_tilt);
        }
    }
}

/// Where a target that goes to the right at 0.05 rad/s is held: its largest P and its largest x in the last
/// 20 s, with a destination that is `ahead_px` to the right of the target.
fn held(framed: Framed, ahead_px: f64) -> (f64, f64) {
    let profile = vehicle_without_lag();
    let settings = LawSettings::new(LawId::Intermittent).showing(framed);
    let mut law = CameraLaw::new(settings, &profile);
    let focal_px = profile.camera.focal_share * f64::from(PICTURE.width);
    let region = Region::from_shares(profile.region, PICTURE);
    let (mut pan, mut largest_p, mut largest_x) = (0.0, 0.0_f64, f64::NEG_INFINITY);
    for k in 0..1200 {
        let t = f64::from(k) * STEP_S;
        let now = Timestamp::from_secs_f64(1.0 + t);
        let position = ImagePoint { x: focal_px * libm::tan(0.05 * t - pan), y: 0.0 };
        let destination = Some(ImagePoint { x: position.x + ahead_px, y: 0.0 });
        let percept = Percept::new(position, region);
        let input = LawInput {
            percept: &percept,
            region,
            destination,
            picture: PICTURE,
            captured: now,
            is_measured: true,
            now,
        };
        let command = law.command(&input);
        law.on_command_applied(command, now);
        pan += STEP_S * rates(command)[0];
        if t > 20.0 {
            largest_p = largest_p.max(percept.p);
            largest_x = largest_x.max(position.x);
        }
    }
    (largest_p, largest_x)
}

#[test]
fn a_destination_ahead_is_shown_by_holding_the_target_back_within_the_region() {
    // The picture ends 320 px from its middle, the region 192 px.
    let (p, x) = held(Framed::Both, 290.0);
    assert!(x + 290.0 < 320.0, "the destination is in the picture all the time: {x}");
    assert!(p <= 1.0, "{p}");
    let (_, alone) = held(Framed::Boat, 290.0);
    assert!(alone + 290.0 > 400.0, "it would be outside of the picture: {alone}");
}

#[test]
fn a_destination_that_is_near_or_cannot_be_shown_changes_nothing() {
    for ahead_px in [60.0, 700.0, f64::NAN] {
        assert_eq!(held(Framed::Both, ahead_px), held(Framed::Boat, ahead_px), "{ahead_px}");
    }
}
