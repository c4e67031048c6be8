//! The names and units of the API, value by value.

use std::sync::Arc;
use std::time::Duration;

use barrelman_control::{Percept, Region};
use barrelman_pilot::{Candidate, ClassName, Classification, Outcome, VesselMode};
use barrelman_video::sender_clock::VideoTiming;
use barrelman_vocab::earth::{GeoPoint, WaterOnEarth};
use barrelman_vocab::telemetry::{ControlState, LinkState};
use barrelman_vocab::track::Shape;
use barrelman_vocab::{
    AngularRate, HoldCause, ImagePoint, LawId, ShortText, StopCause, Track, UsedEquipment, VehicleRates,
    VideoNumber,
};

use serde_json::{Value, json};

use super::*;
use crate::snapshot::{Alarm, BoatOnWater, SharedSnapshot, VehiclePosition};
use crate::test_scenes::{PICTURE, at, command, idle, localisation};

/// The JSON of a snapshot.
fn status(snapshot: Snapshot) -> Value {
    serde_json::to_value(status_of(&snapshot, &Videos::default())).unwrap()
}

/// The JSON after a step.
fn status_after(outcome: Outcome) -> Value {
    status(Snapshot { outcome: Some(outcome), ..Snapshot::default() })
}

#[test]
fn before_the_first_step_nothing_is_known() {
    let status = status(Snapshot::default());
    for (pointer, expected) in [
        ("/step", json!(0)),
        ("/at_ns", json!(0)),
        ("/mode", json!({"name": "idle", "cause": null, "engaged": false})),
        ("/track/state", json!("unseeded")),
        ("/track/box", json!(null)),
        ("/region", json!(null)),
        ("/percept", json!(null)),
        ("/advice", json!(null)),
        ("/command", json!({"pan": 0.0, "tilt": 0.0, "zoom": 0.0})),
        ("/law", json!(null)),
        ("/video/state", json!("connecting")),
        ("/video/size", json!(null)),
        ("/link/state", json!("dry-run")),
        ("/recording", json!({"state": "off", "path": null, "reason": null})),
        ("/alarms", json!([])),
        ("/stops_taken", json!(0)),
        ("/drive", json!(null)),
    ] {
        assert_eq!(status.pointer(pointer), Some(&expected), "{pointer}");
    }
    let work = json!({"moves": 0, "travel_rad": 0.0, "rest_share": 1.0, "seconds": 0.0});
    assert_eq!(status["work"]["camera"], work);
}

#[test]
fn each_mode_has_its_name_and_cause() {
    let holding = |cause| (Mode::Holding(cause), "holding");
    let stopped = |cause| (Mode::Stopped(cause), "stopped");
    for ((mode, name), cause, engaged) in [
        ((Mode::Idle, "idle"), None, false),
        ((Mode::Nudging, "nudging"), None, false),
        ((Mode::Searching, "searching"), None, false),
        ((Mode::Calibrating, "calibrating"), None, false),
        ((Mode::Servoing, "servoing"), None, true),
        (holding(HoldCause::NoSelection), Some("no-selection"), true),
        (holding(HoldCause::TrackLost), Some("track-lost"), true),
        (holding(HoldCause::Coasting), Some("coasting"), true),
        (holding(HoldCause::Doubted), Some("doubted"), true),
        (holding(HoldCause::VideoStale), Some("video-stale"), true),
        (holding(HoldCause::VideoSilent), Some("video-silent"), true),
        (holding(HoldCause::Confirming), Some("confirming"), true),
        (holding(HoldCause::DryRun), Some("dry-run"), true),
        (holding(HoldCause::LinkDown), Some("link-down"), true),
        (holding(HoldCause::NoControl), Some("no-control"), true),
        (holding(HoldCause::Emergency), Some("emergency"), true),
        (holding(HoldCause::Landing), Some("landing"), true),
        (stopped(StopCause::Operator), Some("operator"), false),
        (stopped(StopCause::Ending), Some("ending"), false),
        (stopped(StopCause::VideoEnded), Some("video-ended"), false),
        (stopped(StopCause::Fault), Some("fault"), false),
        (stopped(StopCause::ControlLost), Some("control-lost"), false),
        (stopped(StopCause::VehicleRestarted), Some("vehicle-restarted"), false),
        (stopped(StopCause::Emergency), Some("emergency"), false),
        (stopped(StopCause::Landing), Some("landing"), false),
        (stopped(StopCause::BatteryLow), Some("battery-low"), false),
        (stopped(StopCause::Exchanged), Some("exchanged"), false),
    ] {
        let status = status_after(Outcome { mode, ..idle(at(0)) });
        assert_eq!(status["mode"], json!({"name": name, "cause": cause, "engaged": engaged}));
    }
}

#[test]
fn a_track_is_given_in_pixels_and_degrees() {
    let seen = barrelman_vocab::Localisation {
        shape: Some(Shape { major_px: 40.0, minor_px: 12.5, axis: Angle::from_degrees(30.0) }),
        heading: Some(Angle::from_degrees(210.0)),
        ..localisation(at(100))
    };
    for (track, state) in [(Track::Tracking(seen), "tracking"), (Track::Coasting(seen), "coasting")] {
        let status = status_after(Outcome { track, is_confirming: true, ..idle(at(300)) });
        let track = &status["track"];
        assert_eq!((&track["state"], &track["confirming"]), (&json!(state), &json!(true)));
        assert_eq!(track["captured_ns"], 100_000_000);
        assert_eq!(track["box"], json!([300.0, 230.0, 40.0, 20.0]));
        assert_eq!(track["centre"], json!([320.0, 240.0]));
        assert_eq!(track["axes"], json!([40.0, 12.5]));
        // The rounding of two conversions between degrees and radians.
        assert!((track["axis_deg"].as_f64().unwrap() - 30.0).abs() < 1e-9, "{track}");
        assert!((track["heading_deg"].as_f64().unwrap() - 210.0).abs() < 1e-9, "{track}");
        assert_eq!((&track["confidence"], &track["lost_s"]), (&json!(0.75), &json!(null)));
    }
}

#[test]
fn a_doubt_is_one_of_the_track() {
    let track = Track::Tracking(localisation(at(100)));
    let status = status_after(Outcome { track, is_doubted: true, ..idle(at(300)) });
    assert_eq!((&status["track"]["state"], &status["track"]["doubted"]), (&json!("tracking"), &json!(true)));
}

#[test]
fn a_person_is_proposed_as_a_mark_where_marks_can_be_set() {
    let with = |class: &str, vessel: VesselMode| {
        let class = ClassName::new(class).unwrap();
        let candidate = Candidate {
            number: 2,
            bounds: PixelBox { u: 10.0, v: 20.0, w: 30.0, h: 40.0 },
            captured: at(100),
            classification: Some(Classification { class, score: 0.75 }),
        };
        let mut outcome = Outcome { ..idle(at(300)) };
        (outcome.candidates[1], outcome.vessel.mode) = (Some(candidate), vessel);
        status_after(outcome)["candidates"][0].clone()
    };
    let expected = json!({
        "number": 2, "box": [10.0, 20.0, 30.0, 40.0], "captured_ns": 100_000_000, "class": "person",
        "score": 0.75, "mark": "person",
    });
    assert_eq!(with("person", VesselMode::Released), expected);
    assert_eq!(with("person", VesselMode::Absent)["mark"], json!(null));
    assert_eq!(with("boat", VesselMode::Released)["mark"], json!(null));
}

#[test]
fn a_lost_track_has_no_position() {
    let track = Track::Lost { since: at(500), confidence: 0.25 };
    let status = status_after(Outcome { track, ..idle(at(2000)) });
    let expected = json!({
        "state": "lost", "confirming": false, "doubted": false, "captured_ns": null, "box": null, "centre": null, "axes": null,
        "axis_deg": null, "heading_deg": null, "confidence": 0.25, "lost_s": 1.5,
    });
    assert_eq!(status["track"], expected);
}

#[test]
fn the_sector_is_that_of_the_advice() {
    let region = Region { a_px: 200.0, b_px: 100.0 };
    for (sector, name) in [
        (None, None),
        (Some(Sector::Right), Some("right")),
        (Some(Sector::Top), Some("top")),
        (Some(Sector::Left), Some("left")),
        (Some(Sector::Bottom), Some("bottom")),
    ] {
        let advice = Some(Advice { command: command(0.25, -0.5), sector });
        let percept = Some(Percept::new(ImagePoint { x: 400.0, y: -50.0 }, region));
        let outcome = Outcome { percept, advice, region: Some(region), ..idle(at(0)) };
        let status = status_after(outcome);
        assert_eq!(status["percept"], json!({"x": 400.0, "y": -50.0, "p": 4.25, "sector": name}));
        assert_eq!(status["advice"], json!({"pan": 0.25, "tilt": -0.5, "zoom": 0.0}));
        assert_eq!(status["region"], json!({"a_px": 200.0, "b_px": 100.0}));
        assert_eq!(
            status["command"],
            json!({"pan": 0.0, "tilt": 0.0, "zoom": 0.0}),
            "advice is not in force"
        );
    }
}

#[test]
fn rates_are_given_on_both_sides_of_the_vehicle_boundary() {
    let rate = AngularRate::from_radians_per_second;
    let rates = VehicleRates::turning(rate(-0.25), rate(0.125));
    let outcome = Outcome { command: command(0.25, -0.125), ..idle(at(0)) };
    let status = status(Snapshot { outcome: Some(outcome), rates, ..Snapshot::default() });
    assert_eq!(status["command"], json!({"pan": 0.25, "tilt": -0.125, "zoom": 0.0}));
    assert_eq!((&status["yaw_rate"], &status["pitch_rate"]), (&json!(-0.25), &json!(0.125)));
}

#[test]
fn a_status_names_the_law() {
    for (law, name) in [
        (LawId::Schema, "schema"),
        (LawId::Intermittent, "intermittent"),
        (LawId::MinimumEnergy, "minimum-energy"),
        (LawId::TimeFuel, "time-fuel"),
        (LawId::Eco, "eco"),
    ] {
        assert_eq!(status(Snapshot { law: Some(law), ..Snapshot::default() })["law"], name);
    }
}

#[test]
fn the_video_is_given_in_milliseconds_and_frames_a_second() {
    let lost = VideoSourceState::Lost("timeout".to_owned());
    for (state, timing_text, name, reason) in [
        (VideoSourceState::Connecting, None, "connecting", None),
        (VideoSourceState::Up, None, "up", None),
        (VideoSourceState::Up, Some("late"), "up", Some("late")),
        (lost, Some("late"), "lost", Some("timeout")),
        (VideoSourceState::Ended, None, "ended", None),
    ] {
        let video = VideoSnapshot {
            number: VideoNumber::First,
            source: SourceSnapshot {
                state,
                timing: VideoTiming::InTime,
                timing_text: timing_text.map(Into::into),
            },
            frame: Some((at(40), PICTURE)),
            age: Some(Duration::from_micros(12_500)),
            fps: 25.0,
            step_time: Some(Duration::from_micros(3500)),
            dropped: 3,
        };
        let status =
            status_of(&Snapshot { video, ..Snapshot::default() }, &Videos::one(Some(EncodedVideo::H264)));
        let expected = json!({
            "state": name, "reason": reason, "size": [640, 480], "captured_ns": 40_000_000, "age_ms": 12.5,
            "fps": 25.0, "number": "first", "step_ms": 3.5, "dropped": 3, "codec": "h264",
        });
        assert_eq!(serde_json::to_value(status.video).unwrap(), expected);
    }
}

#[test]
fn each_state_of_the_link_has_its_name() {
    use snapshot::LinkStatus::{DryRun, Link, Simulated};
    for (link, name) in [
        (DryRun, "dry-run"),
        (Simulated, "simulated"),
        (Link(LinkState::Opening), "opening"),
        (Link(LinkState::Starting), "starting"),
        (Link(LinkState::Up), "up"),
        (Link(LinkState::Closing), "closing"),
        (Link(LinkState::Closed), "closed"),
    ] {
        let vehicle = VehicleSnapshot { link, ..VehicleSnapshot::default() };
        let status = status(Snapshot { vehicle, ..Snapshot::default() });
        assert_eq!(status["link"]["state"], name);
        assert_eq!(status["link"]["in_control"], json!(null));
    }
}

#[test]
fn what_is_missing_for_latitude_and_longitude_is_told() {
    let degrees = Angle::from_degrees;
    let place = GeoPoint { latitude: degrees(54.5), longitude: degrees(-10.25) };
    for (earth, name) in [
        (Ok(WaterOnEarth { origin: place, ahead: degrees(90.0) }), "known"),
        (Err(NotOnEarth::NoPosition), "no-position"),
        (Err(NotOnEarth::NoHeading), "no-heading"),
    ] {
        assert_eq!(status_after(Outcome { earth, ..idle(at(0)) })["earth"], name);
    }
    assert_eq!(status(Snapshot::default())["earth"], "no-position", "before the first step");
    let boat = |on_earth| BoatOnWater { distance_m: 20.0, std_dev_m: 1.0, direction: degrees(5.0), on_earth };
    let given = |on_earth| status(Snapshot { boat: Some(boat(on_earth)), ..Snapshot::default() });
    let expected = json!({"latitude_deg": 54.5, "longitude_deg": -10.25});
    assert_eq!(given(Some(place))["boat"]["on_earth"], expected);
    assert_eq!(given(None)["boat"]["on_earth"], json!(null));
}

#[test]
fn telemetry_is_given_in_volts_degrees_and_metres() {
    for (flight, name) in [
        (FlightState::Idle, "idle"),
        (FlightState::Flying, "flying"),
        (FlightState::Landing, "landing"),
        (FlightState::Emergency, "emergency"),
        (FlightState::Other(9), "other"),
    ] {
        let vehicle = VehicleSnapshot {
            control: Some(ControlState::Elsewhere),
            battery_v: Some(15.5),
            tilt: Some(Angle::from_radians(-core::f64::consts::FRAC_PI_2)),
            altitude_m: Some(10.5),
            position: Some(VehiclePosition {
                latitude: Angle::from_degrees(54.5),
                longitude: Angle::from_degrees(-10.25),
                heading: None,
            }),
            flight: Some(flight),
            equipment: UsedEquipment { gimbal: Some(ShortText::of(b"device 1")), ..UsedEquipment::default() },
            ..VehicleSnapshot::default()
        };
        let expected = json!({
            "state": "dry-run", "in_control": false, "acceptance": null, "battery_v": 15.5, "tilt_deg": -90.0, "altitude_m": 10.5,
            "position": {"latitude_deg": 54.5, "longitude_deg": -10.25, "heading_deg": null},
            "flight": name, "gimbal": "device 1", "camera": null, "stream": null,
        });
        assert_eq!(status(Snapshot { vehicle, ..Snapshot::default() })["link"], expected);
    }
}

#[test]
fn a_recording_is_given_with_its_file_or_with_the_reason_of_its_failure() {
    for (recording, expected) in [
        (RecordingState::Off, json!({"state": "off", "path": null, "reason": null})),
        (
            RecordingState::On("a.mcap".to_owned()),
            json!({"state": "recording", "path": "a.mcap", "reason": null}),
        ),
        (
            RecordingState::Failed("full".to_owned()),
            json!({"state": "failed", "path": null, "reason": "full"}),
        ),
    ] {
        assert_eq!(status(Snapshot { recording, ..Snapshot::default() })["recording"], expected);
    }
}

#[test]
fn the_share_at_rest_is_that_of_the_time() {
    for (rest_s, seconds, share) in [(0.0, 0.0, 1.0), (0.0, 8.0, 0.0), (2.0, 8.0, 0.25), (8.0, 8.0, 1.0)] {
        let camera = snapshot::WorkFigures { moves: 3, travel_rad: 1.5, rest_s, seconds };
        let work = snapshot::CameraWork { camera, schema: Some(camera), schema_p: Some(0.5) };
        let status = status(Snapshot { work, ..Snapshot::default() });
        let figures = json!({"moves": 3, "travel_rad": 1.5, "rest_share": share, "seconds": seconds});
        assert_eq!(status["work"], json!({"camera": figures, "schema": figures, "schema_p": 0.5}));
    }
}

#[test]
fn alarms_are_given_by_their_keys() {
    let alarms = vec![Alarm::NoVideo, Alarm::EndStop];
    let shared: SharedSnapshot =
        Arc::new(Snapshot { alarms, stops_taken: 4, steps: 9, ..Snapshot::default() });
    let status = status_of(&shared, &Videos::default());
    assert_eq!(status.alarms, ["no-video", "end-stop"]);
    assert_eq!((status.stops_taken, status.step), (4, 9));
}
