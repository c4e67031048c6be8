//! The camera model against a simulated plant that is integrated in small steps.

use core::time::Duration;
use std::collections::VecDeque;

use barrelman_control::CameraModel;
use barrelman_control::camera_model::UnreportedZoom;
use barrelman_vocab::profile::{AxisRates, CameraDynamics};
use barrelman_vocab::{
    Angle, AngularRate, CameraCommand, PictureSize, PixelPoint, Timestamp, VehicleProfile, ZoomDynamics,
    ZoomRate,
};
use proptest::prelude::*;

/// The plant, in steps of 0.1 ms: dead times, overriding commands, lag.
struct Plant {
    start_s: f64,
    stop_s: f64,
    lag_s: f64,
    pending: VecDeque<(f64, f64)>,
    asked: f64,
    in_effect: f64,
    rate: f64,
    angle: f64,
}

const STEP_S: f64 = 1e-4;

impl Plant {
    fn new(start_s: f64, stop_s: f64, lag_s: f64) -> Self {
        Self {
            start_s,
            stop_s,
            lag_s,
            pending: VecDeque::new(),
            asked: 0.0,
            in_effect: 0.0,
            rate: 0.0,
            angle: 0.0,
        }
    }

    fn command(&mut self, asked: f64, now_s: f64) {
        if asked == self.asked {
            return;
        }
        self.asked = asked;
        let at_s = now_s + if asked == 0.0 { self.stop_s } else { self.start_s };
        while self.pending.back().is_some_and(|(later_s, _)| *later_s >= at_s) {
            self.pending.pop_back();
        }
        self.pending.push_back((at_s, asked));
    }

    fn step(&mut self, now_s: f64) {
        while self.pending.front().is_some_and(|(at_s, _)| *at_s <= now_s + 0.5 * STEP_S) {
            self.in_effect = self.pending.pop_front().unwrap().1;
        }
        self.rate += STEP_S / self.lag_s * (self.in_effect - self.rate);
        self.angle += STEP_S * self.rate;
    }
}

fn profile() -> (CameraDynamics, AxisRates) {
    let profile = VehicleProfile::fotokite_pro();
    (profile.camera, profile.limits)
}

fn pan_at(rate: f64) -> CameraCommand {
    CameraCommand::turning(AngularRate::from_radians_per_second(rate), AngularRate::ZERO)
}

fn seconds(s: f64) -> Timestamp {
    Timestamp::from_secs_f64(s)
}

/// Compares model and plant for commands at times.
fn compare(commands: &[(f64, f64)]) {
    let (dynamics, limits) = profile();
    let pan = dynamics.pan;
    let mut plant = Plant::new(
        pan.start_dead_time.as_secs_f64(),
        pan.stop_dead_time.as_secs_f64(),
        pan.lag.as_secs_f64(),
    );
    let mut model = CameraModel::new(dynamics, limits, None);
    let mut course = Vec::new();
    let end_s = commands.last().unwrap().0;
    let mut next = commands.iter().peekable();
    for step in 0.. {
        let now_s = f64::from(step) * STEP_S;
        if now_s > end_s {
            break;
        }
        while let Some((at_s, rate)) = next.next_if(|(at_s, _)| *at_s <= now_s + 0.5 * STEP_S) {
            plant.command(*rate, *at_s);
            model.apply_command(pan_at(*rate), seconds(*at_s));
        }
        course.push((now_s, plant.angle));
        plant.step(now_s);
    }
    for (at_s, angle) in course.into_iter().rev().take_while(|(at_s, _)| *at_s > end_s - 1.5).step_by(97) {
        let found = model.angles_at(seconds(at_s)).0;
        assert!((found - angle).abs() < 1e-3, "at {at_s} s: {found} against {angle}");
    }
}

#[test]
fn a_start_and_a_stop_are_as_the_plant_has_them() {
    let steps: Vec<(f64, f64)> =
        (0..90).map(|k| (f64::from(k) / 30.0, if (15..45).contains(&k) { 0.3 } else { 0.0 })).collect();
    compare(&steps);
}

#[test]
fn a_stop_is_overruled_by_a_start_that_takes_effect_before_it() {
    let rate = |k| match k {
        10..30 => 0.3,
        33..60 => -0.2,
        _ => 0.0,
    };
    let steps: Vec<(f64, f64)> = (0..90).map(|k| (f64::from(k) / 30.0, rate(k))).collect();
    compare(&steps);
}

#[test]
fn at_the_end_stop_it_stays() {
    let (dynamics, limits) = profile();
    let mut model = CameraModel::new(dynamics, limits, None);
    let down = CameraCommand::turning(AngularRate::ZERO, AngularRate::from_radians_per_second(-0.3));
    for k in 0..300 {
        model.apply_command(down, seconds(f64::from(k) / 30.0));
    }
    let lowest = dynamics.tilt_stops.0.radians();
    assert!((model.angles_at(seconds(9.9)).1 - lowest).abs() < 1e-12);
    for k in 300..360 {
        let up = CameraCommand { tilt: -down.tilt, ..down };
        model.apply_command(up, seconds(f64::from(k) / 30.0));
    }
    // Two seconds up, less dead time and lag: the model left the end stop immediately.
    let risen = model.angles_at(seconds(12.0)).1 - lowest;
    assert!((0.48..0.56).contains(&risen), "{risen}");
}

#[test]
fn a_reported_tilt_is_believed_in_time() {
    let (dynamics, limits) = profile();
    let mut model = CameraModel::new(dynamics, limits, None);
    for k in 0..60 {
        let now = seconds(f64::from(k) / 30.0);
        model.apply_command(CameraCommand::REST, now);
        model.correct_tilt(Angle::from_degrees(-60.0), now);
    }
    assert!((model.angles_at(seconds(2.0)).1.to_degrees() + 60.0).abs() < 0.01);
    model.correct_tilt(Angle::from_radians(f64::NAN), seconds(2.0));
    assert!((model.angles_at(seconds(2.0)).1.to_degrees() + 60.0).abs() < 0.01);
}

#[test]
fn a_tilt_is_taken_over_as_far_as_the_end_stops_allow() {
    let (dynamics, limits) = profile();
    let mut model = CameraModel::new(dynamics, limits, None);
    model.set_tilt(Angle::from_degrees(-60.0), seconds(1.0));
    assert!((model.angles_at(seconds(1.0)).1.to_degrees() + 60.0).abs() < 1e-9);
    model.set_tilt(Angle::from_radians(f64::NAN), seconds(1.0));
    assert!((model.angles_at(seconds(1.0)).1.to_degrees() + 60.0).abs() < 1e-9);
    model.set_tilt(Angle::from_degrees(-170.0), seconds(1.0));
    assert!(model.angles_at(seconds(1.0)).1 >= dynamics.tilt_stops.0.radians() - 1e-9);
}

#[test]
fn a_zoom_counts_from_when_it_was_reported() {
    let (dynamics, limits) = profile();
    let picture = PictureSize::new(1000, 600);
    let mut model = CameraModel::new(dynamics, limits, None);
    let first = 1000.0 * dynamics.focal_share;
    // 2 atan(1/4): the focal length is twice the picture's width.
    model.set_field_of_view(Angle::from_radians(2.0 * libm::atan(0.25)), seconds(1.0));
    assert_eq!(model.focal_px(seconds(0.9), picture), first);
    assert!((model.focal_px(seconds(1.0), picture) - 2000.0).abs() < 1e-9);
    let across = model.motion_prior(seconds(0.9), seconds(1.1), picture);
    assert_eq!((across.shift_u_px, across.std_dev_px), (0.0, 1000.0), "nothing is known of that step");
    assert!(model.motion_prior(seconds(1.1), seconds(1.2), picture).std_dev_px < 100.0);
    for radians in [f64::NAN, 0.0, -1.0, 3.2, 1e9, f64::INFINITY] {
        model.set_field_of_view(Angle::from_radians(radians), seconds(2.0));
        assert!((model.focal_px(seconds(3.0), picture) - 2000.0).abs() < 1e-9, "{radians}");
    }
}

#[test]
fn a_zoom_under_way_is_remembered_as_it_went() {
    let (dynamics, limits) = profile();
    let picture = PictureSize::new(1000, 600);
    let mut model = CameraModel::new(dynamics, limits, None);
    // From 1 to 3 times the picture's width within two seconds, reported twenty times a second.
    for k in 0..=40 {
        let share = 1.0 + 0.05 * f64::from(k);
        let angle = Angle::from_radians(2.0 * libm::atan(0.5 / share));
        model.set_field_of_view(angle, seconds(1.0 + 0.05 * f64::from(k)));
    }
    for k in 12..=40 {
        let at = seconds(1.001 + 0.05 * f64::from(k));
        assert!((model.focal_px(at, picture) - (1000.0 + 50.0 * f64::from(k))).abs() < 1e-6, "{k}");
    }
    let across = model.motion_prior(seconds(2.51), seconds(2.61), picture);
    assert_eq!(across.std_dev_px.to_bits(), 1000.0_f64.to_bits(), "nothing is known of that step");
}

#[test]
fn a_zero_on_its_way_ends_the_turn_though_nothing_more_is_said() {
    let (dynamics, limits) = profile();
    let mut silent = CameraModel::new(dynamics, limits, None);
    silent.apply_command(pan_at(0.3), seconds(1.0));
    silent.apply_command(CameraCommand::REST, seconds(2.0));
    let mut advanced = silent.clone();
    for k in 1..=120 {
        advanced.advance_to(seconds(2.0 + f64::from(k) / 30.0));
    }
    for at_s in [2.1, 2.3, 2.6, 3.0, 6.0] {
        let (silent, advanced) = (silent.angles_at(seconds(at_s)).0, advanced.angles_at(seconds(at_s)).0);
        assert!((silent - advanced).abs() < 1e-4, "{at_s} s: {silent} {advanced}");
    }
    assert!(silent.angles_at(seconds(6.0)).0 < 0.5, "it does not turn for ever");
}

#[test]
fn an_end_stop_holds_though_nothing_more_is_said() {
    let (dynamics, limits) = profile();
    let mut model = CameraModel::new(dynamics, limits, None);
    let up = CameraCommand::turning(AngularRate::ZERO, AngularRate::from_radians_per_second(0.3));
    model.apply_command(up, seconds(1.0));
    let (_, tilt) = model.angles_at(seconds(60.0));
    assert_eq!(tilt.to_bits(), dynamics.tilt_stops.1.radians().to_bits());
}

#[test]
fn no_lag_is_no_trouble() {
    let (mut dynamics, limits) = profile();
    dynamics.pan.lag = Duration::ZERO;
    dynamics.pan.start_dead_time = Duration::ZERO;
    let mut model = CameraModel::new(dynamics, limits, None);
    for k in 0..=30 {
        model.apply_command(pan_at(0.3), seconds(f64::from(k) / 30.0));
    }
    assert!((model.angles_at(seconds(1.0)).0 - 0.3).abs() < 1e-3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn any_commands_at_any_times(
        spans in prop::collection::vec((0.002_f64..0.3, prop_oneof![Just(0.0), -0.4..0.4]), 5..60),
    ) {
        let mut at_s = 0.0;
        let mut commands: Vec<(f64, f64)> = spans
            .into_iter()
            .map(|(span_s, rate)| {
                at_s += libm::round(span_s / STEP_S) * STEP_S;
                (at_s, rate)
            })
            .collect();
        let end_s = at_s + 0.5;
        let last = commands.last().unwrap().1;
        commands.push((libm::round(end_s / STEP_S) * STEP_S, last));
        compare(&commands);
    }

    #[test]
    fn nothing_makes_it_point_nowhere(
        commands in prop::collection::vec((any::<u32>(), prop::num::f64::ANY, prop::num::f64::ANY), 1..200),
    ) {
        let (dynamics, limits) = profile();
        let mut model = CameraModel::new(dynamics, limits, None);
        for (at_us, pan, tilt) in commands {
            let now = Timestamp::from_nanos(u64::from(at_us) * 1000);
            let command = CameraCommand::turning(AngularRate::from_radians_per_second(pan), AngularRate::from_radians_per_second(tilt));
            model.apply_command(command, now);
            let (pan, tilt) = model.angles_at(now);
            prop_assert!(pan.is_finite() && tilt.is_finite());
        }
    }
}

#[test]
fn the_picture_shifts_against_the_turn_once_a_command_shows_and_is_known_less_well_then() {
    let profile = VehicleProfile::fotokite_pro();
    let at = |seconds: f64| Timestamp::from_secs_f64(seconds);
    let size = PictureSize::new(1280, 720);
    let turned = |pan: f64, tilt: f64| {
        let mut camera = CameraModel::of(&profile);
        let [pan, tilt] = [pan, tilt].map(AngularRate::from_radians_per_second);
        camera.apply_command(CameraCommand::turning(pan, tilt), at(10.0));
        [camera.motion_prior(at(10.0), at(10.04), size), camera.motion_prior(at(12.0), at(12.04), size)]
    };
    let [before, right] = turned(0.3, 0.0);
    assert!(before.shift_u_px.abs() < 1e-9 && before.shift_v_px.abs() < 1e-9, "{before:?}");
    // 660 px of focal length, 0.3 rad/s for 40 ms, at a depression of 24 degrees: 7.2 px.
    assert!((-7.9..-6.5).contains(&right.shift_u_px) && right.shift_v_px.abs() < 1.0, "{right:?}");
    assert!(right.std_dev_px > before.std_dev_px && before.std_dev_px > 1.0, "{right:?}, {before:?}");
    let [_, up] = turned(0.0, 0.2);
    assert!(up.shift_v_px > 4.0 && up.shift_u_px.abs() < 1e-9, "{up:?}");
    assert_eq!(up.interval, Duration::from_millis(40));
}

/// A camera that zooms up to four times at 0.2 per second, 0.1 s after a command.
fn zooming() -> CameraModel {
    let zoom = ZoomDynamics {
        ratio: 4.0,
        max_rate: ZoomRate::from_per_second(0.2),
        dead_time: Duration::from_millis(100),
    };
    CameraModel::of(&VehicleProfile { zoom: Some(zoom), ..VehicleProfile::fotokite_pro() })
}

/// The focal length over the widest one.
fn factor_at(model: &CameraModel, at_s: f64) -> f64 {
    model.focal_share_at(seconds(at_s)) / VehicleProfile::fotokite_pro().camera.focal_share
}

#[test]
fn the_focal_length_follows_the_commands_to_zoom_up_to_the_ends() {
    let mut model = zooming();
    let closer = CameraCommand::REST.zooming(ZoomRate::from_per_second(9.0));
    model.apply_command(closer, seconds(1.0));
    assert!((factor_at(&model, 1.1) - 1.0).abs() < 1e-9);
    for tenth in 11..=40 {
        model.advance_to(seconds(0.1 * f64::from(tenth)));
    }
    assert!((factor_at(&model, 3.1) - libm::exp(0.4)).abs() < 1e-3);
    assert!((factor_at(&model, 60.0) - 4.0).abs() < 1e-9);
    model.apply_command(CameraCommand::REST, seconds(4.0));
    let rested = factor_at(&model, 4.2);
    assert!((rested - libm::exp(0.6)).abs() < 1e-3 && (factor_at(&model, 60.0) - rested).abs() < 1e-9);
    model.apply_command(CameraCommand::REST.zooming(-ZoomRate::from_per_second(0.2)), seconds(5.0));
    assert!((factor_at(&model, 60.0) - 1.0).abs() < 1e-9);
}

#[test]
fn a_zoom_by_command_predicts_how_the_picture_grows() {
    let mut model = zooming();
    let size = PictureSize::new(1280, 720);
    model.apply_command(CameraCommand::REST.zooming(ZoomRate::from_per_second(0.2)), seconds(1.0));
    (11..=20).for_each(|tenth| model.advance_to(seconds(0.1 * f64::from(tenth))));
    let prior = model.motion_prior(seconds(1.9), seconds(2.0), size);
    assert!((prior.scale - libm::exp(0.02)).abs() < 1e-4, "{prior:?}");
    assert!(prior.std_dev_px < 50.0 && prior.shift_u_px.abs() < 1e-9 && prior.shift_v_px.abs() < 1e-9);
    // 400 px right of the centre and 100 px below it.
    let moved = prior.at(PixelPoint { u: 1040.0, v: 460.0 }, size);
    assert!((moved.shift_u_px - 8.08).abs() < 0.05 && (moved.shift_v_px - 2.02).abs() < 0.02, "{moved:?}");
}

#[test]
fn reports_correct_a_zoom_by_command_a_little_and_one_by_somebody_else_at_once() {
    let mut model = zooming();
    let report = |model: &mut CameraModel, factor: f64, at_s: f64| {
        let share = factor * VehicleProfile::fotokite_pro().camera.focal_share;
        model.set_field_of_view(Angle::from_radians(2.0 * libm::atan(0.5 / share)), seconds(at_s));
    };
    model.apply_command(CameraCommand::REST.zooming(ZoomRate::from_per_second(0.2)), seconds(1.0));
    (11..=20).for_each(|tenth| model.advance_to(seconds(0.1 * f64::from(tenth))));
    let before = factor_at(&model, 2.0);
    report(&mut model, 1.1 * before, 2.0);
    let after = factor_at(&model, 2.0);
    assert!((after / before - libm::pow(1.1, 0.2)).abs() < 1e-3, "{before} {after}");
    let prior = model.motion_prior(seconds(1.9), seconds(2.0), PictureSize::new(1280, 720));
    assert!(prior.std_dev_px < 50.0, "the picture did not jump: {prior:?}");
    model.apply_command(CameraCommand::REST, seconds(2.0));
    for tenth in 21..=40 {
        model.advance_to(seconds(0.1 * f64::from(tenth)));
    }
    report(&mut model, 3.0, 4.0);
    assert!((factor_at(&model, 4.0) - 3.0).abs() < 1e-9);
    model.apply_command(CameraCommand::REST.zooming(ZoomRate::from_per_second(0.2)), seconds(4.1));
    assert!((factor_at(&model, 60.0) - 4.0).abs() < 1e-9, "the ends are where they were");
}

#[test]
fn the_growth_of_the_picture_tells_the_focal_length_of_a_camera_that_reports_nothing() {
    let mut model = zooming();
    let at = |frame: u32| seconds(1.0 + f64::from(frame) / 30.0);
    assert_eq!(model.unreported_zoom(at(0)), Some(UnreportedZoom::Resting));
    model.apply_command(CameraCommand::REST.zooming(ZoomRate::from_per_second(0.2)), at(0));
    // The camera is half as fast as its profile says.
    for frame in 1..=90 {
        model.advance_to(at(frame));
        model.on_growth(0.1 / 30.0, at(frame - 1), at(frame));
    }
    assert_eq!(model.unreported_zoom(at(90)), Some(UnreportedZoom::Moving));
    let factor = factor_at(&model, 4.0);
    assert!((factor / libm::exp(0.3) - 1.0).abs() < 1e-3, "{factor}");
    // No camera zooms so fast.
    model.on_growth(0.5, at(89), at(90));
    model.on_growth(f64::NAN, at(89), at(90));
    assert_eq!(factor_at(&model, 4.0), factor);
    model.set_field_of_view(Angle::from_degrees(60.0), at(90));
    assert_eq!(model.unreported_zoom(at(90)), None, "reports are better");
}

#[test]
fn a_camera_without_zoom_has_no_growth_to_measure() {
    let model = CameraModel::of(&VehicleProfile::fotokite_pro());
    assert_eq!(model.unreported_zoom(seconds(1.0)), None);
}
