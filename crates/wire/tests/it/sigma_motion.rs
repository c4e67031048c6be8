//! Commands to turn and zeros, against a Sigma in virtual time.

use std::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{FlightState, LinkState, Report};
use barrelman_vocab::{Angle, VehicleRates, ZoomAbility, ZoomRate};
use barrelman_wire::fotokite_sigma::{Call, FotokiteSigmaSession};
use barrelman_wire::http::motion::Speeds as _;
use barrelman_wire::http::{HttpCall as _, Lane, Received};
use barrelman_wire::{NextAction, RestEvidence, Session as _};
use proptest::prelude::*;

use crate::sigma_conversation::{Conversation, at, rates};
use crate::talk::Talk as _;

#[test]
fn the_first_command_is_a_zero() {
    let mut talk = Conversation::new();
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(600);
    let first = talk.sent.iter().find_map(|(_, request)| match request.call {
        Call::Turn { speeds, .. } => Some(speeds),
        _ => None,
    });
    assert!(first.unwrap().is_rest());
    assert!(!talk.turning().is_rest());
}

#[test]
fn a_motion_is_renewed_without_a_gap_and_ends_with_zeros() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, -5.0), Some(at(60_000)));
    assert_eq!(talk.run_until(50, |talk| !talk.turning().is_rest()), Some(5), "one way of 4 ms");
    for _ in 0..5_000 {
        talk.run_for(1);
        assert!(!talk.turning().is_rest(), "{:?}", talk.now);
    }
    let since = talk.now;
    talk.session.request(VehicleRates::REST, None);
    assert_eq!(talk.run_until(50, |talk| talk.turning().is_rest()), Some(5));
    talk.run_for(3_000);
    let zeros = talk.commands_since(since);
    assert!((3..=12).contains(&zeros), "{zeros} zeros");
    assert_eq!(talk.sigma.refusals(), 0);
}

#[test]
fn without_renewal_the_motion_ends_within_half_a_second_of_the_last_request() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    // Every lane is dead: the program was killed.
    talk.hung = Call::LANES.iter().map(|lane| (*lane, false)).collect();
    let ended = talk.run_until(1_000, |talk| talk.turning().is_rest()).unwrap();
    assert!(ended <= 455, "{ended} ms");
}

#[test]
fn where_zeros_are_refused_the_motion_ends_soon_after_the_time_of_renewal() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(1_300)));
    let renewed = talk.now.plus(Duration::from_millis(300));
    talk.session.request(rates(10.0, 0.0), Some(renewed));
    talk.run_for(200);
    // A vehicle that lands refuses commands, zeros too, and carries out the last one to its end.
    talk.sigma.set_flight_state("Landing");
    talk.run_until(1_000, |talk| talk.turning().is_rest()).unwrap();
    let late = talk.now.since(renewed).as_millis();
    assert!(late <= 155, "{late} ms after the time of renewal");
}

#[test]
fn one_lost_command_does_not_interrupt_the_motion() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    let sent = talk.commands_since(at(0));
    talk.hung = vec![(Lane::Turn, false)];
    talk.run_until(200, |talk| talk.commands_since(at(0)) > sent).unwrap();
    talk.hung.clear();
    for _ in 0..1_000 {
        talk.run_for(1);
        assert!(!talk.turning().is_rest(), "{:?}", talk.now);
    }
}

#[test]
fn a_hung_command_holds_up_no_zero() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    talk.hung = vec![(Lane::Turn, true)];
    talk.run_for(160);
    talk.session.request(VehicleRates::REST, None);
    let ended = talk.run_until(100, |talk| talk.turning().is_rest());
    assert!(ended.is_some_and(|ms| ms <= 6), "{ended:?}");
}

#[test]
fn zeros_that_hang_take_the_other_lane_and_the_motion_ends_by_itself() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    talk.hung = vec![(Lane::Stop, false)];
    talk.session.request(VehicleRates::REST, None);
    let ended = talk.run_until(500, |talk| talk.turning().is_rest()).unwrap();
    assert!(ended <= 110, "{ended} ms: the next zero, a tenth of a second later");
}

#[test]
fn a_refused_command_is_told_and_tried_again() {
    for (state, expected) in [("Landing", Acceptance::FlightState), ("TakingOff", Acceptance::FlightState)] {
        let mut talk = Conversation::up();
        talk.sigma.set_flight_state(state);
        talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
        talk.run_for(300);
        assert_eq!(talk.acceptance(), Some(expected), "{state}");
        talk.sigma.set_flight_state("Flying");
        talk.run_for(5_000);
        assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
        assert!(!talk.turning().is_rest());
    }
}

#[test]
fn a_service_that_is_not_ready_is_told_and_the_control_is_kept_or_asked_for_again() {
    let mut talk = Conversation::up();
    talk.sigma.set_ready(false);
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::NotReady));
    talk.run_for(20_000);
    talk.sigma.set_ready(true);
    talk.run_for(5_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
    assert!(!talk.turning().is_rest());
}

#[test]
fn the_states_of_camera_lens_and_flight_are_reported() {
    for has_socket in [true, false] {
        let mut talk = Conversation::new();
        talk.has_socket = has_socket;
        talk.run_for(2_000);
        let has = |wanted: &dyn Fn(&Report) -> bool| talk.reports.iter().any(wanted);
        assert!(has(
            &|report| matches!(report, Report::CameraTilt(tilt) if (tilt.degrees() + 24.0).abs() < 1e-9)
        ));
        assert!(has(&|report| *report == Report::FieldOfView(Angle::from_degrees(60.0))));
        let flying = Report::FlightState { state: FlightState::Flying, is_battery_low: false };
        assert!(has(&|report| *report == flying));
        let tilts = talk.reports.iter().filter(|report| matches!(report, Report::CameraTilt(_))).count();
        assert!((8..=25).contains(&tilts), "{tilts} reports, socket {has_socket}");
    }
}

#[test]
fn a_message_that_cannot_be_read_does_not_replace_the_reading() {
    let mut talk = Conversation::up();
    talk.has_socket = false;
    let since = talk.now;
    for _ in 0..20 {
        talk.session.received(&Received::Message(b"{\"hello\": 1}".to_vec()), talk.now, &mut |_| {});
        talk.run_for(100);
    }
    let reads = talk.sent.iter().filter(|(when, request)| *when > since && request.call == Call::CameraState);
    assert!(reads.count() >= 6);
}

#[test]
fn a_close_while_turning_sends_zeros_and_releases_the_control() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    talk.session.close(talk.now);
    assert_eq!(talk.run_until(50, |talk| talk.turning().is_rest()), Some(5));
    let closed = talk.run_until(2_500, |talk| talk.last == NextAction::Closed).unwrap();
    assert!(closed < 1_000, "{closed} ms");
    assert!(!talk.sigma.is_controlled(talk.now));
    assert_eq!(talk.session.rest_evidence(talk.now), RestEvidence::AtRest);
}

#[test]
fn a_close_without_answers_ends_too() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    talk.hung = Call::LANES.iter().map(|lane| (*lane, false)).collect();
    talk.has_socket = false;
    talk.session.close(talk.now);
    assert!(talk.run_until(2_100, |talk| talk.last == NextAction::Closed).is_some());
    assert!(talk.turning().is_rest());
}

#[test]
fn a_silent_vehicle_ends_the_session() {
    let mut talk = Conversation::up();
    talk.hung = Call::LANES.iter().map(|lane| (*lane, false)).collect();
    talk.has_socket = false;
    let silent = talk.run_until(4_000, |talk| matches!(talk.last, NextAction::Reopen { .. })).unwrap();
    assert!((2_500..=3_100).contains(&silent), "{silent} ms");
    assert_eq!(talk.session.link_state(), LinkState::Silent);
}

#[derive(Debug, Clone)]
enum Event {
    Rates(f64, f64),
    Rest,
    Hang(usize, bool),
    Heal,
    Theft,
    GiveBack,
    Engage,
    NotReady(bool),
    Slow(u64),
}

fn events() -> impl Strategy<Value = Vec<(u64, Event)>> {
    let event = prop_oneof![
        4 => (-30.0..30.0, -30.0..30.0).prop_map(|(yaw, pitch)| Event::Rates(yaw, pitch)),
        3 => Just(Event::Rest),
        2 => (0..6_usize, any::<bool>()).prop_map(|(lane, arrives)| Event::Hang(lane, arrives)),
        2 => Just(Event::Heal),
        1 => Just(Event::Theft),
        1 => Just(Event::GiveBack),
        1 => Just(Event::Engage),
        1 => any::<bool>().prop_map(Event::NotReady),
        1 => (1..200_u64).prop_map(Event::Slow),
    ];
    proptest::collection::vec((1..700_u64, event), 1..25)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever happens, the camera rests 450 ms after rest was requested, and the way there; no request is
    /// refused as unusable.
    #[test]
    fn rest_comes_within_the_duration(events in events()) {
        let mut talk = Conversation::up();
        let mut rest_since = None;
        for (ms, event) in events {
            match event {
                Event::Rates(yaw, pitch) => {
                    talk.session.request(rates(yaw, pitch), Some(at(600_000)));
                    rest_since = None;
                }
                Event::Rest => {
                    talk.session.request(VehicleRates::REST, None);
                    rest_since.get_or_insert(talk.now);
                }
                Event::Hang(lane, arrives) => talk.hung.push((Call::LANES[lane], arrives)),
                Event::Heal => talk.hung.clear(),
                Event::Theft => talk.sigma.other_client_takes(),
                Event::GiveBack => talk.sigma.other_client_releases(talk.now),
                Event::Engage => talk.session.take_control(talk.now),
                Event::NotReady(is_not) => talk.sigma.set_ready(!is_not),
                Event::Slow(ms) => talk.delay = std::time::Duration::from_millis(ms),
            }
            for _ in 0..ms {
                talk.run_for(1);
                if let Some(since) = rest_since {
                    let over = talk.now.since(since).as_millis();
                    let bound = 450 + talk.delay.as_millis() + 10;
                    prop_assert!(over <= bound || talk.turning().is_rest(), "turning {over} ms after rest");
                }
            }
        }
        prop_assert_eq!(talk.sigma.refusals(), 0);
    }
}

#[test]
fn a_zoom_goes_on_in_small_steps_while_it_is_wanted_and_ends_with_the_last_one() {
    let mut talk = Conversation::up();
    let speed = |talk: &Conversation| talk.turning().zoom;
    talk.session.request(VehicleRates::REST.zooming(1.0), Some(at(60_000)));
    assert!(talk.run_until(700, |talk| speed(talk) > 0.0).is_some(), "once the level was told");
    talk.run_for(2_000);
    let level = |talk: &Conversation| {
        let asked = talk.sent.iter().rev().find_map(|(_, request)| match request.call {
            Call::Zoom { level, .. } => Some(level),
            _ => None,
        });
        asked.unwrap()
    };
    assert!((1.7..2.1).contains(&level(&talk)), "0.3 for 2 to 2.4 s: {}", level(&talk));
    talk.session.request(VehicleRates::REST, None);
    talk.run_for(250);
    assert_eq!(speed(&talk), 0.0);
    let steps = |talk: &Conversation| {
        talk.sent.iter().filter(|(_, request)| matches!(request.call, Call::Zoom { .. })).count()
    };
    let sent = steps(&talk);
    talk.run_for(3_000);
    assert_eq!(steps(&talk), sent);

    talk.session.request(rates(5.0, 0.0).zooming(-0.5), Some(at(60_000)));
    talk.run_for(600);
    assert!(talk.turning().yaw.radians_per_second() > 0.0 && steps(&talk) > sent, "both at once");
    talk.sigma.other_client_takes();
    talk.run_for(500);
    let sent = steps(&talk);
    talk.run_for(2_000);
    assert_eq!((speed(&talk), steps(&talk)), (0.0, sent), "another client has the control");
    assert_eq!(talk.sigma.refusals(), 0);
}

#[test]
fn whether_the_stream_zooms_is_reported() {
    assert_eq!(Conversation::up().zoom(), ZoomAbility::Present);
    let full_zoom = ZoomRate::from_per_second(0.3);
    let mut talk = Conversation::new();
    talk.session = FotokiteSigmaSession::open(Some("thermal".to_owned()), full_zoom, at(0));
    assert_eq!(talk.zoom(), ZoomAbility::NotKnown);
    talk.run_for(1_500);
    assert_eq!(talk.zoom(), ZoomAbility::Absent);
}
