//! What can be said to a Sigma, and how rates become speeds.

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::{AngularRate, CameraCommand, Named as _, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_sigma::call::{MAX_STATUS_CHARACTERS, SelfStatus, StreamId, TURN_DURATION};
use barrelman_wire::fotokite_sigma::sigma::SigmaSettings;
use barrelman_wire::fotokite_sigma::speeds::Speeds;
use barrelman_wire::fotokite_sigma::{Call, json};
use barrelman_wire::http::HttpCall as _;
use proptest::prelude::*;

use crate::sigma_conversation::rates;

/// One call of each kind. The match makes the list complete: a new kind does not compile without its line
/// here.
fn every_call() -> Vec<Call> {
    let calls = vec![
        Call::CameraInfo,
        Call::CameraState,
        Call::Subscribe,
        Call::VideoStreams,
        Call::VideoStreamState { stream: StreamId::new("zoom").unwrap() },
        Call::FlightState,
        Call::SystemState,
        Call::Notifications,
        Call::RequestControl,
        Call::ReleaseControl,
        Call::STOP,
        Call::Zoom { stream: StreamId::new("zoom").unwrap(), level: 2.0 },
        Call::ShowStatus { status: SelfStatus::Connected, text: "" },
    ];
    for call in &calls {
        match call {
            Call::CameraInfo | Call::CameraState | Call::Subscribe | Call::VideoStreams => {}
            Call::VideoStreamState { .. } | Call::FlightState | Call::SystemState | Call::Notifications => {}
            Call::RequestControl | Call::ReleaseControl | Call::Turn { .. } | Call::ShowStatus { .. } => {}
            Call::Zoom { .. } => {}
        }
    }
    calls
}

#[test]
fn these_paths_are_all_that_can_be_called() {
    let calls: Vec<_> =
        every_call().iter().map(|call| format!("{:?} {}", call.method(), call.path())).collect();
    assert_eq!(
        calls,
        [
            "Get /v1/camera/info",
            "Get /v1/camera/state",
            "Get /v1/camera/state/subscribe",
            "Get /v1/videostreams",
            "Get /v1/videostreams/zoom/state",
            "Get /v1/flight/state",
            "Get /v1/system/state",
            "Get /v1/notifications/state",
            "Post /v1/handoff/control/request",
            "Post /v1/handoff/control/release",
            "Post /v1/camera/control/rotate_with_speed",
            "Post /v1/videostreams/zoom/control/zoom",
            "Post /v1/auth/plugin/update",
        ]
    );
}

#[test]
fn a_stream_s_name_cannot_lead_to_another_path() {
    for name in ["", "../../flight/control/takeoff", "a/b", "a?b", "a b", "a%2fb", ".."] {
        assert_eq!(StreamId::new(name), None, "{name}");
    }
    assert!(StreamId::new("thermal_2-a").is_some());
}

#[test]
fn a_command_names_speeds_and_a_short_duration() {
    let info = SigmaSettings::example().camera;
    let speeds = Speeds::within(rates(5.0, -3.5), &info);
    let body = Call::Turn { speeds, duration: TURN_DURATION }.body().unwrap();
    assert_eq!(body, r#"{"duration":0.45,"pan_speed":5.0,"tilt_speed":-3.5}"#);
    let body = Call::STOP.body().unwrap();
    assert_eq!(body, r#"{"duration":0.1,"pan_speed":0.0,"tilt_speed":0.0}"#);
}

#[test]
fn pan_right_and_tilt_up_become_clockwise_and_negative() {
    let profile = VehicleProfile::fotokite_sigma();
    let rate = AngularRate::from_radians_per_second(0.2);
    let sent = Speeds::within(
        profile.to_vehicle(CameraCommand::turning(rate, rate)),
        &SigmaSettings::example().camera,
    );
    assert!(sent.pan_deg_per_s() > 11.0 && sent.tilt_deg_per_s() < -11.0, "{sent:?}");
}

#[test]
fn the_least_rate_of_the_profile_is_not_below_the_vehicle_s() {
    let least = VehicleProfile::fotokite_sigma().camera.pan.min_rate;
    let speeds = Speeds::within(VehicleRates::turning(least, -least), &SigmaSettings::example().camera);
    assert_eq!((speeds.pan_deg_per_s(), speeds.tilt_deg_per_s()), (2.0, -2.0));
}

#[test]
fn every_text_fits_the_tablet() {
    for said in Acceptance::ALL.iter().copied() {
        assert!(said.text().chars().count() <= MAX_STATUS_CHARACTERS, "{said:?}");
    }
}

#[test]
fn the_zoom_s_stream_is_the_main_one() {
    let streams = r#"[{"stream_id":"thermal","type":"Thermal"},{"stream_id":"overview","type":"Color"},
        {"stream_id":"zoom","type":"Color","rtsp_url":"rtsp://camera.example/zoom","new_field":1}]"#;
    let streams: Vec<json::VideoStream> = json::read(streams.as_bytes()).unwrap();
    assert_eq!(
        json::main_stream(&streams, None).unwrap().rtsp_url.as_deref(),
        Some("rtsp://camera.example/zoom")
    );
    assert_eq!(json::main_stream(&streams[..2], None).unwrap().stream_id, "overview");
    assert_eq!(json::main_stream(&streams[..1], None).unwrap().stream_id, "thermal");
    assert_eq!(json::main_stream(&streams, Some("thermal")).unwrap().stream_id, "thermal");
    assert!(json::main_stream(&streams[..2], Some("zoom")).is_none(), "no other takes its place");
}

proptest! {
    #[test]
    fn a_speed_is_zero_or_within_the_camera_s_limits(
        yaw in prop_oneof![-60.0..60.0, Just(f64::NAN), Just(f64::INFINITY)],
        pitch in -60.0..60.0_f64,
        least in 0.0..9.0_f64,
        span in -2.0..30.0_f64,
    ) {
        let info = json::CameraInfo {
            pan_speed_min: least,
            pan_speed_max: least + span,
            tilt_speed_min: least,
            tilt_speed_max: least + span,
        };
        let speeds = Speeds::within(rates(yaw, pitch), &info);
        for (speed, wanted) in [(speeds.pan_deg_per_s(), yaw), (speeds.tilt_deg_per_s(), pitch)] {
            let is_allowed = speed == 0.0 || (speed.abs() >= least && speed.abs() <= least + span);
            prop_assert!(is_allowed, "{speed} for {wanted}");
            prop_assert!(speed == 0.0 || speed * wanted > 0.0, "{speed} for {wanted}");
            prop_assert!(speed.abs() <= wanted.abs() + 0.001 || !wanted.is_finite());
        }
    }
}
