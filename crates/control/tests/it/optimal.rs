//! The optimal law, alone and with a camera that obeys it.

use core::time::Duration;

use barrelman_control::optimal::{OptimalLaw, OptimalMode, OptimalSettings, Tuning};
use barrelman_control::{CameraLaw, LawInput, LawSettings, Percept, Region};
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, PictureSize, Timestamp, VehicleProfile};
use proptest::prelude::*;

const PICTURE: PictureSize = PictureSize::new(640, 480);
const STEP_S: f64 = 1.0 / 30.0;
const MODES: [OptimalMode; 3] = [OptimalMode::MinimumEnergy, OptimalMode::TimeFuel, OptimalMode::Eco];

fn law(mode: OptimalMode, profile: &VehicleProfile) -> CameraLaw {
    CameraLaw::new(LawSettings::Optimal(OptimalSettings::new(mode)), profile)
}

fn rates(command: CameraCommand) -> [f64; 2] {
    [command.pan.radians_per_second(), command.tilt.radians_per_second()]
}

/// One look at a target, a tenth of a second ago, and what the law makes of it.
fn look(
    law: &mut CameraLaw,
    profile: &VehicleProfile,
    position: ImagePoint,
    now: Timestamp,
) -> CameraCommand {
    let region = Region::from_shares(profile.region, PICTURE);
    let percept = Percept::new(position, region);
    let captured = now.minus(Duration::from_millis(100));
    let command = law.command(&LawInput {
        percept: &percept,
        region,
        picture: PICTURE,
        captured,
        is_measured: true,
        now,
    });
    law.on_command_applied(command, now);
    command
}

/// A camera that obeys at once, and a target whose bearing turns steadily: where it is in the picture, and the
/// commands, for `seconds`.
fn follow(
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
        // Seen near the horizontal, so that pan and azimuth are one; what is seen is 100 ms old.
        let seen_pan = pans[pans.len() - 4];
        let azimuth = libm::atan(start_px / focal_px) + speed * (t - 0.1) - seen_pan;
        let position = ImagePoint { x: focal_px * libm::tan(azimuth), y: 0.0 };
        let command = look(&mut law, profile, position, Timestamp::from_secs_f64(1.0 + t));
        pan += STEP_S * rates(command)[0];
        pans.push(pan);
        course.push((position.x, command));
    }
    course
}

/// A vehicle that answers at once and looks straight ahead.
fn prompt_vehicle() -> VehicleProfile {
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
            let command = look(&mut law, &profile, ImagePoint { x: 120.0, y: -60.0 }, now);
            assert_eq!(command, CameraCommand::REST, "{mode:?} at look {k}");
        }
    }
}

#[test]
fn a_target_that_leaves_is_kept_and_then_the_camera_rests() {
    for mode in MODES {
        let course = follow(mode, &prompt_vehicle(), 0.0, 0.12, 20.0);
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
        let course = follow(mode, &prompt_vehicle(), 260.0, 0.0, 45.0);
        assert!(course[0].0 > 250.0);
        let (x, _) = course[(8.0 / STEP_S) as usize];
        assert!(x.abs() < 192.0, "{mode:?}: {x} px after 8 s");
        let (x, command) = *course.last().unwrap();
        assert!(x.abs() < 192.0 && command.is_rest(), "{mode:?}: {x} px, {command:?}");
    }
}

#[test]
fn looking_down_steeply_pan_is_spared() {
    let first = |down: f64, thrift: f64| {
        let mut profile = VehicleProfile::fotokite_pro();
        profile.camera.initial_tilt = barrelman_vocab::Angle::from_degrees(-down);
        let tuning = Tuning { steep_view_gain: thrift, horizon_s: 3.0, ..Tuning::MINIMUM_ENERGY };
        let mut law = CameraLaw::from_law(Box::new(OptimalLaw::with_tuning(tuning, &profile)), &profile);
        rates(look(&mut law, &profile, ImagePoint { x: 190.0, y: 0.0 }, Timestamp::from_secs_f64(1.0)))[0]
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
        let [pan, tilt] = rates(look(&mut law, &profile, ImagePoint { x: 200.0, y: 110.0 }, now));
        assert!(pan >= 0.0 && tilt >= 0.0, "towards the target");
        both |= pan > 0.0 && tilt > 0.0;
    }
    assert!(both);
}

#[test]
fn a_vehicle_s_least_rate_is_respected() {
    let mut profile = VehicleProfile::fotokite_pro();
    let least = 0.2;
    for axis in [&mut profile.camera.pan, &mut profile.camera.tilt] {
        axis.min_rate = AngularRate::from_radians_per_second(least);
    }
    let mut law = law(OptimalMode::MinimumEnergy, &profile);
    let mut moved = false;
    for k in 0..600 {
        let t = f64::from(k) * STEP_S;
        let position = ImagePoint { x: 260.0 * libm::sin(0.7 * t), y: 130.0 * libm::cos(0.4 * t) };
        for rate in rates(look(&mut law, &profile, position, Timestamp::from_secs_f64(1.0 + t))) {
            assert!(rate == 0.0 || rate.abs() >= least - 1e-12, "{rate} rad/s");
            moved |= rate != 0.0;
        }
    }
    assert!(moved);
}

#[test]
fn a_vehicle_that_cannot_creep_fetches_a_slow_target_to_the_middle_all_the_same() {
    let mut profile = prompt_vehicle();
    for axis in [&mut profile.camera.pan, &mut profile.camera.tilt] {
        axis.min_rate = AngularRate::from_radians_per_second(0.035);
    }
    // 1.2 rad in all, where the region is 0.5 rad wide to each side.
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
    let zoomed = prompt_vehicle();
    let mut built = zoomed.clone();
    built.camera.focal_share = 2.0;
    let (mut told, mut born) =
        (law(OptimalMode::MinimumEnergy, &zoomed), law(OptimalMode::MinimumEnergy, &built));
    let field_of_view = barrelman_vocab::Angle::from_radians(2.0 * libm::atan(0.25));
    told.on_field_of_view_report(field_of_view, Timestamp::from_secs_f64(0.5));
    for k in 0..60 {
        let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
        let position = ImagePoint { x: 4.0 * f64::from(k), y: -f64::from(k) };
        let [a, b] = [(&mut told, &zoomed), (&mut born, &built)]
            .map(|(law, profile)| rates(look(law, profile, position, now)));
        assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9, "{k}: {a:?} {b:?}");
        assert!(k < 55 || a[0] > 0.0, "{k}: it leaves");
    }
}

#[test]
fn a_zoom_under_way_is_no_motion_of_the_target() {
    // A target that stands beside the middle, well inside of the region however near the camera shows it.
    let vehicle = prompt_vehicle();
    let mut law = law(OptimalMode::MinimumEnergy, &vehicle);
    for k in 0..90 {
        let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
        let share = if k < 30 { vehicle.camera.focal_share } else { 2.0 * vehicle.camera.focal_share };
        let field_of_view = barrelman_vocab::Angle::from_radians(2.0 * libm::atan(0.5 / share));
        law.on_field_of_view_report(field_of_view, now.minus(Duration::from_millis(100)));
        let position = ImagePoint { x: 640.0 * share * libm::tan(0.12), y: 0.0 };
        assert_eq!(rates(look(&mut law, &vehicle, position, now)), [0.0, 0.0], "{k}");
    }
}

#[test]
fn what_the_tracker_expects_is_no_look() {
    // A target that goes out to the right, and a tracker that then expects it here or there.
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
            let input =
                LawInput { percept: &percept, region, picture: PICTURE, captured, is_measured: seen, now };
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
    // Disengaged: what it asks for is never in force. The target goes out, comes back, and stands well inside.
    for mode in MODES {
        let profile = VehicleProfile::fotokite_pro();
        let mut law = law(mode, &profile);
        let mut last = CameraCommand::REST;
        let mut asked_to_move = false;
        for k in 0..300 {
            let t = f64::from(k) * STEP_S;
            let x = 115.0 + 115.0 * libm::sin((1.2 * t).min(core::f64::consts::PI));
            let now = Timestamp::from_secs_f64(1.0 + t);
            last = look(&mut law, &profile, ImagePoint { x, y: 0.0 }, now);
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
        // A target that stands above what the camera can tilt up to, and a camera that obeys at once.
        for k in 0..900 {
            let now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
            let focal_px = camera.focal_share * f64::from(PICTURE.width);
            let y = focal_px * libm::tan(0.6 - tilt);
            last = look(&mut law, &profile, ImagePoint { x: 0.0, y }, now);
            tilt = (tilt + STEP_S * rates(last)[1]).min(camera.tilt_stops.1.radians());
            moved |= !last.is_rest();
        }
        assert!(moved && last.is_rest(), "{mode:?}: {last:?} at {tilt}");
        assert!(camera.tilt_stops.1.radians() - tilt < 0.05, "{mode:?}: it goes as far as it can, {tilt}");
    }
}

#[test]
fn a_pause_between_pictures_is_counted() {
    // A camera that turns while no picture comes for half a second: what is known of it then is the same as if the law
    // had been told of every moment.
    let profile = VehicleProfile::fotokite_pro();
    let commands = [1, 15].map(|parts| {
        let mut law = law(OptimalMode::MinimumEnergy, &profile);
        let mut command = CameraCommand::REST;
        let mut now = Timestamp::from_secs_f64(1.0);
        for k in 0..30 {
            now = Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S);
            command = look(&mut law, &profile, ImagePoint { x: 150.0 + 4.0 * f64::from(k), y: 0.0 }, now);
        }
        assert!(!command.is_rest());
        for _ in 1..parts {
            now = now.plus(Duration::from_millis(500 / parts));
            law.on_command_applied(command, now);
        }
        let now = Timestamp::from_secs_f64(1.0 + 29.0 * STEP_S + 0.5);
        rates(look(&mut law, &profile, ImagePoint { x: 200.0, y: 0.0 }, now))
    });
    // What is remembered in between is told apart by a cubic.
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
        rates(look(&mut law, &profile, ImagePoint { x: 300.0, y: 0.0 }, Timestamp::from_secs_f64(1.0)));
    assert!(pan >= 0.38, "{pan} rad/s");
}

#[test]
fn a_longer_horizon_is_lazier() {
    let profile = VehicleProfile::fotokite_pro();
    let effort = |horizon_s: f64| {
        let settings = OptimalSettings { mode: OptimalMode::MinimumEnergy, horizon_s: Some(horizon_s) };
        let mut law = CameraLaw::new(LawSettings::Optimal(settings), &profile);
        let [pan, _] =
            rates(look(&mut law, &profile, ImagePoint { x: 190.0, y: 0.0 }, Timestamp::from_secs_f64(1.0)));
        pan
    };
    let (tight, lazy) = (effort(1.5), effort(4.0));
    assert!(tight > lazy && lazy > 0.0, "{tight} {lazy}");
}

#[test]
fn after_a_gap_it_begins_anew() {
    let profile = VehicleProfile::fotokite_pro();
    let mut law = law(OptimalMode::MinimumEnergy, &profile);
    // Running out of the picture to the right, unseen for a second, and then at rest in the middle.
    for k in 0..20 {
        let position = ImagePoint { x: 10.0 * f64::from(k), y: 0.0 };
        look(&mut law, &profile, position, Timestamp::from_secs_f64(1.0 + f64::from(k) * STEP_S));
    }
    law.on_command_applied(CameraCommand::REST, Timestamp::from_secs_f64(1.9));
    let command = look(&mut law, &profile, ImagePoint { x: 0.0, y: 0.0 }, Timestamp::from_secs_f64(3.0));
    assert_eq!(command, CameraCommand::REST);
}

/// A look of any kind.
fn any_looks() -> impl Strategy<Value = Vec<(f64, f64, u16)>> {
    let coordinate = prop_oneof![4 => -400.0_f64..400.0, 1 => prop::num::f64::ANY];
    prop::collection::vec(
        (coordinate.clone(), coordinate, prop_oneof![8 => 20_u16..50, 1 => any::<u16>()]),
        1..120,
    )
}

proptest! {
    #[test]
    fn whatever_is_seen_the_rates_are_within_the_limits(looks in any_looks(), mode in 0_usize..3) {
        let profile = VehicleProfile::fotokite_pro();
        let mut law = law(MODES[mode], &profile);
        let mut now_ms = 1_000_u64;
        for (x, y, span_ms) in looks {
            now_ms += u64::from(span_ms);
            let now = Timestamp::from_nanos(now_ms * 1_000_000);
            let [pan, tilt] = rates(look(&mut law, &profile, ImagePoint { x, y }, now));
            prop_assert!(pan.abs() <= profile.limits.pan.radians_per_second(), "{} rad/s", pan);
            prop_assert!(tilt.abs() <= profile.limits.tilt.radians_per_second(), "{} rad/s", tilt);
        }
    }

    #[test]
    fn mirrored_left_to_right_it_pans_the_other_way(looks in any_looks(), mode in 0_usize..3) {
        let profile = VehicleProfile::fotokite_pro();
        let (mut law, mut mirrored) = (law(MODES[mode], &profile), law(MODES[mode], &profile));
        let mut now_ms = 1_000_u64;
        for (x, y, span_ms) in looks {
            now_ms += u64::from(span_ms);
            let now = Timestamp::from_nanos(now_ms * 1_000_000);
            let [pan, tilt] = rates(look(&mut law, &profile, ImagePoint { x, y }, now));
            let [other_pan, other_tilt] = rates(look(&mut mirrored, &profile, ImagePoint { x: -x, y }, now));
            prop_assert!((pan + other_pan).abs() < 1e-9, "{} {}", pan, other_pan);
            prop_assert!((tilt - other_tilt).abs() < 1e-9, "{} {}", tilt, other_tilt);
        }
    }
}
