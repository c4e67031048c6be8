//! The zoom: by hand, to keep the target's size, and in a search.

use core::time::Duration;
use std::sync::Arc;

use barrelman_pilot::{CommandPath, Input, Mode, Notice, Outcome, Pilot, PilotSettings, Refusal};
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{
    Angle, CameraRequest, HoldCause, ImagePoint, Localisation, Nudge, OperatorRequest, Picture, PictureSize,
    PixelBox, StopCause, Telemetry, Timestamp, Track, VehicleProfile, VideoFrame, ZoomAbility, ZoomDynamics,
    ZoomRate,
};

use crate::scenes::{PICTURE, Scripted, at, frame, seen, settings};

const CENTRE: ImagePoint = ImagePoint { x: 0.0, y: 0.0 };

fn zooming_pilot() -> Pilot {
    let zoom = ZoomDynamics {
        ratio: 8.0,
        max_rate: ZoomRate::from_per_second(0.25),
        dead_time: Duration::from_millis(100),
    };
    let profile = VehicleProfile { zoom: Some(zoom), ..VehicleProfile::fotokite_pro() };
    Pilot::new(PilotSettings { profile, ..settings() }, Box::new(Scripted::default()))
}

fn ask(pilot: &mut Pilot, request: impl Into<OperatorRequest>, ms: u64) -> Outcome {
    pilot.step(Input::Request(request.into()), at(ms))
}

const fn zoom_by_hand(zoom: f64) -> CameraRequest {
    CameraRequest::Nudge(Nudge { pan: 0.0, tilt: 0.0, zoom })
}

/// A target whose box has sides of 2:1, this share of the picture's height long.
fn sized(size: f64, point: ImagePoint, captured: Timestamp) -> Localisation {
    let length = size * f64::from(PICTURE.height);
    let centre = point.in_pixels(PICTURE);
    let bounds =
        PixelBox { u: centre.u - 0.5 * length, v: centre.v - 0.25 * length, w: length, h: 0.5 * length };
    Localisation { bounds, ..seen(point, captured) }
}

/// Shows the pilot a target every 33 ms from one time to another.
fn show(pilot: &mut Pilot, (from, to): (u64, u64), size: f64, point: ImagePoint) -> Outcome {
    let step = |ms| {
        let captured = at(ms).minus(Duration::from_millis(200));
        pilot.step(Input::Localisation(Track::Tracking(sized(size, point, captured))), at(ms))
    };
    (from..to).step_by(33).map(step).last().unwrap()
}

/// The vehicle tells whether its camera zooms.
fn tell(pilot: &mut Pilot, zoom: ZoomAbility, ms: u64) -> Outcome {
    pilot.step(Input::Telemetry(Telemetry { at: at(ms), report: Report::Zoom(zoom) }), at(ms))
}

fn rate(outcome: &Outcome) -> f64 {
    outcome.command.zoom.per_second()
}

#[test]
fn an_operator_zooms_by_hand_disengaged_and_engaged_as_long_as_it_is_renewed() {
    let mut pilot = zooming_pilot();
    show(&mut pilot, (0, 100), 0.05, CENTRE);
    let outcome = ask(&mut pilot, zoom_by_hand(1.0), 110);
    assert_eq!((outcome.mode, rate(&outcome)), (Mode::Nudging, 0.25), "within the limit of the vehicle");
    assert!(ask(&mut pilot, zoom_by_hand(0.0), 150).command.is_rest());

    ask(&mut pilot, CameraRequest::Engage, 200);
    show(&mut pilot, (201, 300), 0.05, CENTRE);
    let outcome = ask(&mut pilot, zoom_by_hand(-0.5), 310);
    assert_eq!((outcome.mode, rate(&outcome)), (Mode::Servoing, -0.15));
    let ends = outcome.wake_at.unwrap();
    assert!(ends > at(310) && ends <= at(560), "{ends:?}");
    assert_eq!(rate(&show(&mut pilot, (330, 540), 0.05, CENTRE)), -0.15);
    assert_eq!(rate(&show(&mut pilot, (561, 600), 0.05, CENTRE)), 0.0, "not renewed");
}

#[test]
fn a_zoom_by_hand_does_not_turn_the_camera_and_turning_by_hand_is_refused_while_it_follows() {
    let mut pilot = zooming_pilot();
    ask(&mut pilot, CameraRequest::Engage, 0);
    show(&mut pilot, (1, 100), 0.05, ImagePoint { x: 250.0, y: 0.0 });
    let before = ask(&mut pilot, zoom_by_hand(1.0), 110);
    assert!(before.command.pan.radians_per_second() > 0.0 && rate(&before) > 0.0, "both at once");
    let turn = CameraRequest::Nudge(Nudge { pan: -1.0, tilt: 0.0, zoom: 1.0 });
    let outcome = ask(&mut pilot, turn, 120);
    assert_eq!(outcome.notice, Some(Notice::RequestRefused(Refusal::Engaged)));
    assert_eq!(outcome.command.pan, before.command.pan);
}

#[test]
fn a_zoom_by_hand_goes_on_without_a_target_and_ends_by_a_stop_or_without_video() {
    let mut pilot = zooming_pilot();
    ask(&mut pilot, CameraRequest::Engage, 0);
    show(&mut pilot, (1, 100), 0.05, CENTRE);
    let lost = |pilot: &mut Pilot, ms: u64| {
        let since = at(ms).minus(Duration::from_millis(200));
        pilot.step(Input::Localisation(Track::Lost { since, confidence: 0.0 }), at(ms))
    };
    lost(&mut pilot, 400);
    let outcome = ask(&mut pilot, zoom_by_hand(-1.0), 410);
    assert_eq!((outcome.mode, rate(&outcome)), (Mode::Holding(HoldCause::TrackLost), -0.25));
    assert!(outcome.command.pan.is_zero() && outcome.command.tilt.is_zero());

    let stopped = ask(&mut pilot, OperatorRequest::Stop(StopCause::Operator), 420);
    assert!(stopped.command.is_rest());
    let refused = ask(&mut pilot, zoom_by_hand(-1.0), 430);
    assert_eq!(refused.notice, Some(Notice::RequestRefused(Refusal::Stopped)));
    assert!(refused.command.is_rest());
    assert!(ask(&mut pilot, CameraRequest::Engage, 440).command.is_rest(), "it does not come back");

    lost(&mut pilot, 500);
    assert!(rate(&ask(&mut pilot, zoom_by_hand(1.0), 510)) > 0.0);
    assert_eq!(rate(&ask(&mut pilot, zoom_by_hand(1.0), 790)), 0.25);
    let silent = ask(&mut pilot, zoom_by_hand(1.0), 810);
    assert_eq!(silent.notice, Some(Notice::RequestRefused(Refusal::NoFreshVideo)));
    assert!(silent.command.is_rest());
}

#[test]
fn nothing_zooms_a_camera_without_zoom_or_a_vehicle_that_takes_no_commands() {
    let mut fixed = Pilot::new(settings(), Box::new(Scripted::default()));
    show(&mut fixed, (0, 100), 0.05, CENTRE);
    for request in [zoom_by_hand(1.0), CameraRequest::KeepSize { keep: true }] {
        let outcome = ask(&mut fixed, request, 110);
        assert_eq!(outcome.notice, Some(Notice::RequestRefused(Refusal::NoZoom)), "{request:?}");
        assert!(outcome.command.is_rest() && outcome.zoom.is_none());
    }
    let mut pilot = zooming_pilot().commanding(CommandPath::Link);
    let link = |state, ms| Input::Telemetry(Telemetry { at: at(ms), report: Report::Link(state) });
    pilot.step(link(LinkState::Up, 0), at(0));
    tell(&mut pilot, ZoomAbility::Present, 0);
    ask(&mut pilot, CameraRequest::Engage, 1);
    show(&mut pilot, (2, 100), 0.05, CENTRE);
    assert!(rate(&ask(&mut pilot, zoom_by_hand(1.0), 110)) > 0.0);
    assert!(pilot.step(link(LinkState::Starting, 120), at(120)).command.is_rest());
    let refused = ask(&mut pilot, zoom_by_hand(1.0), 130);
    assert_eq!(refused.notice, Some(Notice::RequestRefused(Refusal::NoMotion(HoldCause::LinkDown))));
}

#[test]
fn a_camera_zooms_once_its_vehicle_has_told_that_it_can() {
    let mut pilot = zooming_pilot().commanding(CommandPath::Link);
    tell(&mut pilot, ZoomAbility::Present, 0);
    ask(&mut pilot, CameraRequest::KeepSize { keep: true }, 0);
    tell(&mut pilot, ZoomAbility::NotKnown, 0);
    let up = Report::Link(LinkState::Up);
    pilot.step(Input::Telemetry(Telemetry { at: at(0), report: up }), at(0));
    ask(&mut pilot, CameraRequest::Engage, 1);
    let refused = |pilot: &mut Pilot, why: Refusal, ms: u64| {
        let outcome = show(pilot, (ms, ms + 500), 0.01, CENTRE);
        assert_eq!((rate(&outcome), outcome.zoom), (0.0, None), "the size is not kept");
        for request in [zoom_by_hand(1.0), CameraRequest::KeepSize { keep: true }] {
            let outcome = ask(pilot, request, ms + 500);
            assert_eq!(outcome.notice, Some(Notice::RequestRefused(why)), "{request:?}");
            assert_eq!((rate(&outcome), outcome.zoom), (0.0, None));
        }
    };
    refused(&mut pilot, Refusal::ZoomNotKnown, 10);
    tell(&mut pilot, ZoomAbility::Absent, 600);
    refused(&mut pilot, Refusal::NoZoom, 610);
    assert!(tell(&mut pilot, ZoomAbility::Present, 1200).zoom.unwrap().keeps_size);
    assert!(rate(&show(&mut pilot, (1210, 4000), 0.01, CENTRE)) > 0.0);
    assert_eq!(rate(&tell(&mut pilot, ZoomAbility::Absent, 4010)), 0.0, "at once");
}

#[test]
fn the_size_is_kept_while_engaged_until_the_operator_zooms() {
    let mut pilot = zooming_pilot();
    let on = ask(&mut pilot, CameraRequest::KeepSize { keep: true }, 0);
    assert_eq!(on.notice, Some(Notice::KeepingSize(true)));
    let disengaged = show(&mut pilot, (1, 2000), 0.01, CENTRE);
    assert!(disengaged.command.is_rest(), "without a licence there is advice alone");
    assert!(disengaged.advice.unwrap().command.zoom.per_second() > 0.0);
    ask(&mut pilot, CameraRequest::Engage, 2000);
    let closer = show(&mut pilot, (2001, 6000), 0.01, CENTRE);
    assert!(rate(&closer) > 0.0 && closer.zoom.unwrap().ratio > 1.2, "{:?}", closer.zoom);
    assert!(rate(&show(&mut pilot, (6001, 6100), 0.01, ImagePoint { x: 250.0, y: 0.0 })) <= 0.0, "outside");

    let by_hand = ask(&mut pilot, zoom_by_hand(-1.0), 6110);
    assert_eq!(by_hand.notice, Some(Notice::KeepingSize(false)));
    assert!(!by_hand.zoom.unwrap().keeps_size);
    assert!(show(&mut pilot, (6400, 9000), 0.01, CENTRE).command.is_rest(), "it is not kept any more");
}

#[test]
fn a_target_that_coasts_near_the_border_widens_the_view_within_the_licence() {
    let mut pilot = zooming_pilot();
    ask(&mut pilot, CameraRequest::KeepSize { keep: true }, 0);
    ask(&mut pilot, CameraRequest::Engage, 1);
    assert!(show(&mut pilot, (2, 6000), 0.01, CENTRE).zoom.unwrap().ratio > 1.2);
    let near = ImagePoint { x: 170.0, y: 0.0 };
    let coasts = |pilot: &mut Pilot, ms: u64| {
        let captured = at(ms).minus(Duration::from_millis(200));
        pilot.step(Input::Localisation(Track::Coasting(sized(0.01, near, captured))), at(ms))
    };
    assert_eq!(rate(&coasts(&mut pilot, 6010)), -0.25);
    assert_eq!(rate(&coasts(&mut pilot, 6200)), -0.25);
    assert!(coasts(&mut pilot, 6400).command.is_rest(), "a coasting target renews nothing");
}

#[test]
fn a_search_widens_the_view() {
    let mut pilot = zooming_pilot();
    ask(&mut pilot, CameraRequest::KeepSize { keep: true }, 0);
    ask(&mut pilot, CameraRequest::Engage, 1);
    show(&mut pilot, (2, 6000), 0.01, CENTRE);
    let lost = |pilot: &mut Pilot, ms: u64| {
        pilot.step(Input::Localisation(Track::Lost { since: at(5900), confidence: 0.0 }), at(ms))
    };
    (6000..9200).step_by(33).for_each(|ms| {
        lost(&mut pilot, ms);
    });
    ask(&mut pilot, CameraRequest::Search, 9210);
    let searching = lost(&mut pilot, 9240);
    assert_eq!((searching.mode, rate(&searching)), (Mode::Searching, -0.25));
    let wide = (9270..20_000).step_by(33).map(|ms| lost(&mut pilot, ms)).last().unwrap();
    assert_eq!((wide.mode, rate(&wide)), (Mode::Searching, 0.0));
    assert!((wide.zoom.unwrap().ratio - 1.0).abs() < 1e-9, "{:?}", wide.zoom);
}

/// A picture of smooth noise, enlarged around its middle.
fn enlarged(scale: f64, captured: Timestamp) -> VideoFrame {
    let size = PictureSize::new(640, 360);
    let corner = |x: i64, y: i64| {
        let mut state = (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663)) as u32;
        state = (state ^ (state >> 15)).wrapping_mul(0x2c1b_3c6d);
        f64::from((state ^ (state >> 12)).wrapping_mul(0x297a_2d39) >> 24)
    };
    let mut picture = Picture::black(size, ColourEncoding::JPEG);
    let [luma, ..] = picture.planes_mut();
    for (index, sample) in luma.iter_mut().enumerate() {
        let (x, y) = ((index % 640) as f64 - 320.0, (index / 640) as f64 - 180.0);
        let (x, y) = (x / scale / 6.0 + 100.0, y / scale / 6.0 + 100.0);
        let (i, j, p, q) = (x as i64, y as i64, x.fract(), y.fract());
        let top = corner(i, j) * (1.0 - p) + corner(i + 1, j) * p;
        let bottom = corner(i, j + 1) * (1.0 - p) + corner(i + 1, j + 1) * p;
        *sample = (top * (1.0 - q) + bottom * q) as u8;
    }
    VideoFrame { picture: Arc::new(picture), ..frame(0, captured) }
}

#[test]
fn the_picture_tells_the_focal_length_of_a_camera_that_reports_nothing_and_zooms_slower_than_its_profile() {
    let mut pilot = zooming_pilot();
    // The picture grows by 0.02 per second at rest, and by 0.12 more from 2.1 s to 5.1 s: 0.25 by the
    // profile.
    let grown = |s: f64| 0.02 * s + 0.12 * (s - 2.1).clamp(0.0, 3.0);
    let mut ratio = 1.0;
    for ms in (0..7000).step_by(50) {
        if (2000..5000).contains(&ms) {
            ask(&mut pilot, zoom_by_hand(1.0), ms);
        }
        let captured_s = 0.001 * ms as f64;
        let outcome = pilot.step(Input::Frame(&enlarged(libm::exp(grown(captured_s)), at(ms))), at(ms));
        ratio = outcome.zoom.unwrap().ratio;
    }
    let zoomed = libm::log(ratio);
    assert!((zoomed / 0.36 - 1.0).abs() < 0.15, "{zoomed}");
}

#[test]
fn a_zoom_is_known_after_a_while_with_the_video_of_another_camera() {
    let mut pilot = zooming_pilot();
    let change = |pilot: &mut Pilot, field_of_view, ms| {
        let report = Report::OtherVideo(field_of_view);
        pilot.step(Input::Telemetry(Telemetry { at: at(ms), report }), at(ms));
    };
    for ms in (0..6_000).step_by(33) {
        ask(&mut pilot, zoom_by_hand(1.0), ms);
        show(&mut pilot, (ms + 1, ms + 2), 0.5, CENTRE);
    }
    let ratio = |outcome: &Outcome| outcome.zoom.map(|zoom| zoom.ratio);
    let before = ratio(&show(&mut pilot, (6_300, 9_000), 0.5, CENTRE));
    assert!(before.is_some_and(|ratio| ratio > 2.0), "{before:?}");
    change(&mut pilot, Some(Angle::from_degrees(40.0)), 9_100);
    let other = show(&mut pilot, (9_110, 9_120), 0.5, CENTRE);
    assert_eq!(ratio(&other), None, "the other camera does not zoom");
    let refused = ask(&mut pilot, zoom_by_hand(1.0), 9_150).notice;
    assert_eq!(refused, Some(Notice::RequestRefused(Refusal::NoZoom)));
    change(&mut pilot, None, 9_200);
    assert_eq!(ratio(&show(&mut pilot, (9_210, 12_000), 0.5, CENTRE)), before);
}
