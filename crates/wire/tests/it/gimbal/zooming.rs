//! The zoom of a vehicle's camera, beside the rates of its gimbal.

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, ComponentId, MavlinkPeers};
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Angle, VehicleRates, ZoomAbility};
use barrelman_wire::mavlink::frame::FrameWriter;
use barrelman_wire::mavlink::gimbal_manager::{CameraKind, GimbalManagerSettings};
use barrelman_wire::{LinkHistory, NextAction, Session as _};
use mavlink::dialects::common::{COMMAND_ACK_DATA, MavCmd, MavResult};

use super::bench::{Bench, Sent, at, rates, sent};

const SET_CAMERA_ZOOM: u32 = 531;
const CAMERA: Address = Address::new(1, 100);

fn peers() -> MavlinkPeers {
    MavlinkPeers { camera: Some(ComponentId(100)), ..MavlinkPeers::DEFAULT }
}

fn up() -> Bench {
    let mut bench = Bench::with_peers(GimbalManagerSettings::default(), peers());
    bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
    bench
}

/// The speeds that were sent to the camera since a time.
fn speeds(bench: &Bench, since_ms: u64) -> Vec<f32> {
    let speed = |(ms, sent): &(u64, Sent)| match sent {
        Sent::Command(SET_CAMERA_ZOOM, to, kind, speed) if *ms >= since_ms => {
            assert_eq!((*to, *kind), (CAMERA, 1.0));
            Some(*speed)
        }
        _ => None,
    };
    bench.sent.iter().filter_map(speed).collect()
}

#[test]
fn a_zoom_is_repeated_while_it_is_wanted_and_followed_by_zeros_until_they_are_answered() {
    let mut bench = up();
    bench.run(Duration::from_millis(1_000));
    let first = speeds(&bench, 0);
    assert!((3..=5).contains(&first.len()) && first.iter().all(|speed| *speed == 0.0), "{first:?}");
    let begun = bench.now_ms;
    bench.session.request(rates(0.1, 0.0).zooming(-0.5), None);
    bench.run(Duration::from_millis(2_000));
    assert_eq!(bench.manager.rates(), rates(f64::from(0.1_f32), 0.0).zooming(-0.5));
    let sent_speeds = speeds(&bench, begun);
    assert!(sent_speeds.len() >= 18 && sent_speeds.iter().all(|speed| *speed == -0.5), "{sent_speeds:?}");
    let rested = bench.now_ms;
    bench.session.request(VehicleRates::REST, None);
    bench.run(Duration::from_millis(5));
    assert_eq!(bench.manager.rates().zoom, 0.0, "at once");
    bench.run(Duration::from_millis(3_000));
    let zeros = speeds(&bench, rested);
    assert!((6..=10).contains(&zeros.len()) && zeros.iter().all(|speed| *speed == 0.0), "{zeros:?}");
    let answered = bench.now_ms;
    bench.run(Duration::from_secs(3));
    assert_eq!(speeds(&bench, answered), [0.0; 0], "another client may zoom now");
}

#[test]
fn zeros_that_fail_or_that_are_of_another_client_are_not_taken_for_answered() {
    for (result, to, is_repeated) in [
        (MavResult::MAV_RESULT_ACCEPTED, MavlinkPeers::DEFAULT.own, false),
        (MavResult::MAV_RESULT_DENIED, MavlinkPeers::DEFAULT.own, false),
        (MavResult::MAV_RESULT_FAILED, MavlinkPeers::DEFAULT.own, true),
        (MavResult::MAV_RESULT_TEMPORARILY_REJECTED, MavlinkPeers::DEFAULT.own, true),
        (MavResult::MAV_RESULT_ACCEPTED, Address::new(255, 190), true),
    ] {
        let mut bench = up();
        bench.session.request(VehicleRates::REST.zooming(1.0), None);
        bench.run(Duration::from_millis(500));
        bench.session.request(VehicleRates::REST, None);
        // What the vehicle itself answers gets lost.
        bench.passes.1 = false;
        let mut writer = FrameWriter::new(Address::new(1, 1), None);
        for _ in 0..8 {
            bench.run(Duration::from_millis(250));
            let answer = COMMAND_ACK_DATA {
                command: MavCmd::MAV_CMD_SET_CAMERA_ZOOM,
                result,
                progress: 0,
                result_param2: 0,
                target_system: to.system.0,
                target_component: to.component.0,
            };
            bench.passes.1 = true;
            let packet = writer.write(&answer);
            bench.deliver(&[packet]);
            bench.passes.1 = false;
        }
        let since = bench.now_ms;
        bench.run(Duration::from_secs(1));
        assert_eq!(!speeds(&bench, since).is_empty(), is_repeated, "{result:?} {to}");
    }
}

#[test]
fn zeros_that_get_lost_are_sent_until_they_arrive() {
    let mut bench = up();
    bench.session.request(VehicleRates::REST.zooming(1.0), None);
    bench.run(Duration::from_millis(500));
    bench.passes.0 = false;
    bench.session.request(VehicleRates::REST, None);
    bench.run(Duration::from_secs(2));
    assert_eq!(bench.manager.rates().zoom, 1.0);
    bench.passes.0 = true;
    bench.run(Duration::from_millis(255));
    assert_eq!(bench.manager.rates().zoom, 0.0);
}

#[test]
fn every_end_stops_the_zoom() {
    let mut bench = up();
    bench.session.request(VehicleRates::REST.zooming(1.0), None);
    bench.run(Duration::from_millis(500));
    assert!(bench.manager.rates().zoom == 1.0 && bench.session.may_be_turning());
    let will = bench.session.last_will(at(bench.now_ms));
    let zeros =
        will.iter().filter(|step| sent(&step.packet) == Sent::Command(SET_CAMERA_ZOOM, CAMERA, 1.0, 0.0));
    assert_eq!(zeros.count(), 3);
    let closed = bench.now_ms;
    bench.session.close(at(closed));
    bench.run_until("the session has ended", |bench| bench.last == NextAction::Closed);
    assert_eq!(bench.manager.rates(), VehicleRates::REST);
    assert!(speeds(&bench, closed).len() >= 3);
}

#[test]
fn what_a_session_before_has_left_is_stopped_before_the_control_is_ours() {
    let mut bench = Bench::with_peers(GimbalManagerSettings::default(), peers());
    bench.session.resume(LinkHistory { may_be_turning: true, ..LinkHistory::default() });
    bench.run(Duration::from_millis(10));
    let first = bench.sent.iter().find_map(|(_, sent)| match sent {
        Sent::Command(SET_CAMERA_ZOOM, to, ..) => Some(*to),
        _ => None,
    });
    assert_eq!(first, Some(Address::new(0, 100)), "the camera of every vehicle");
}

#[test]
fn without_a_camera_that_zooms_nothing_is_told_to() {
    let mut bench = Bench::up(GimbalManagerSettings::default());
    bench.session.request(rates(0.1, 0.0).zooming(1.0), None);
    bench.run(Duration::from_millis(1_000));
    assert!(!bench.sent.iter().any(|(_, sent)| sent.is_command(SET_CAMERA_ZOOM)));
}

#[test]
fn the_field_of_view_is_asked_for_and_reported() {
    let mut bench = up();
    bench.manager.set_field_of_view(Some(Angle::from_degrees(40.0)));
    bench.run(Duration::from_millis(2_000));
    let told = bench.reports.iter().filter_map(|(_, report)| match report {
        Report::FieldOfView(angle) => Some(angle.degrees()),
        _ => None,
    });
    let told: Vec<f64> = told.collect();
    assert!(told.len() >= 4 && told.iter().all(|degrees| (degrees - 40.0).abs() < 1e-4), "{told:?}");
}

/// A session that is up, with a camera of this kind; it is told to zoom for this time.
fn told_to_zoom(camera: CameraKind, time: Duration) -> Bench {
    let mut bench = Bench::with_peers(GimbalManagerSettings { camera, ..Default::default() }, peers());
    bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
    bench.session.request(VehicleRates::REST.zooming(1.0), None);
    bench.run(time);
    bench
}

/// What the session has reported of the zoom.
fn told(bench: &Bench) -> Vec<ZoomAbility> {
    let told = |(_, report): &(u64, Report)| match report {
        Report::Zoom(told) => Some(*told),
        _ => None,
    };
    bench.reports.iter().filter_map(told).collect()
}

/// How often the camera was asked what it is.
fn questions(bench: &Bench) -> usize {
    bench.sent.iter().filter(|(_, sent)| *sent == Sent::Command(512, CAMERA, 259.0, 0.0)).count()
}

#[test]
fn a_camera_that_says_that_it_zooms_is_told_to_and_asked_again_every_five_seconds() {
    let bench = told_to_zoom(CameraKind::Zooming, Duration::from_secs(20));
    assert_eq!((told(&bench), bench.manager.rates().zoom), (vec![ZoomAbility::Present], 1.0));
    assert!((4..=6).contains(&questions(&bench)), "{}", questions(&bench));
}

#[test]
fn a_camera_that_says_that_it_does_not_zoom_is_never_told_to() {
    let mut bench = told_to_zoom(CameraKind::Fixed, Duration::from_secs(10));
    assert_eq!(told(&bench), [ZoomAbility::Absent]);
    bench.session.close(at(bench.now_ms));
    bench.run_until("the session has ended", |bench| bench.last == NextAction::Closed);
    let speeds = speeds(&bench, 0);
    assert!(speeds.len() <= 1 && speeds.iter().all(|speed| *speed == 0.0), "before it told: {speeds:?}");
}

#[test]
fn a_camera_that_says_nothing_is_asked_ever_more_rarely_and_is_not_zoomed() {
    let mut bench = told_to_zoom(CameraKind::Silent, Duration::from_secs(60));
    let before = speeds(&bench, 0);
    assert!(told(&bench).is_empty() && !before.is_empty(), "it may have been left zooming");
    assert!(before.iter().all(|speed| *speed == 0.0), "{before:?}");
    assert!((13..=16).contains(&questions(&bench)), "{}", questions(&bench));
    let closed = bench.now_ms;
    bench.session.close(at(closed));
    bench.run_until("the session has ended", |bench| bench.last == NextAction::Closed);
    let zeros = speeds(&bench, closed);
    assert!(zeros.len() >= 3 && zeros.iter().all(|speed| *speed == 0.0), "an earlier session: {zeros:?}");
}

#[test]
fn a_camera_that_no_longer_says_that_it_zooms_is_stopped() {
    let mut bench = told_to_zoom(CameraKind::Zooming, Duration::from_secs(2));
    assert_eq!(bench.manager.rates().zoom, 1.0);
    bench.manager.set_settings(GimbalManagerSettings { camera: CameraKind::Fixed, ..Default::default() });
    let exchanged = bench.now_ms;
    bench.run(Duration::from_secs(10));
    let sent = speeds(&bench, exchanged);
    let zeros = sent.iter().rev().take_while(|speed| **speed == 0.0).count();
    assert!((3..=14).contains(&zeros), "{sent:?}");
}
