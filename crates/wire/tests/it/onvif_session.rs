//! The session with ONVIF cameras: questions, motion, zeros, refusals, hostile answers.

use std::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{VehicleRates, ZoomAbility};
use barrelman_wire::http::Received;
use barrelman_wire::onvif::{
    Ask, CameraFaults, CameraSettings, FullSpeeds, Login, OnvifSession, OnvifSettings, PtzCamera,
    SpeedShares, soap,
};
use barrelman_wire::{NextAction, RestEvidence, Session as _};
use proptest::prelude::*;

use crate::onvif_conversation::{OnvifConversation, rates, speeds};
use crate::sigma_conversation::at;
use crate::talk::Talk as _;

fn login() -> Login {
    Login::new("admin".to_owned(), "pass&word".to_owned())
}

fn camera() -> CameraSettings {
    CameraSettings::example()
}

fn with_login() -> CameraSettings {
    // A clock that was never set.
    CameraSettings { login: Some(login()), clock: "1970-01-01T00:03:07Z".parse().unwrap(), ..camera() }
}

#[test]
fn the_first_command_is_a_stop_and_the_time_is_asked_for_first() {
    let mut talk = OnvifConversation::new(
        with_login(),
        OnvifSettings { login: Some(login()), speeds: Some(speeds()), profile: None },
    );
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(600);
    assert_eq!(talk.sent[0].1, Ask::DateAndTime);
    assert!(matches!(talk.commands_since(at(0))[0], Ask::Stop { .. }));
    assert_eq!(talk.camera.velocity(talk.now), SpeedShares::turning(0.3, 0.0));
    assert_eq!(talk.camera.refusals(), 0);
}

#[test]
fn a_motion_is_renewed_without_a_gap_and_ends_with_zeros_of_both_kinds() {
    let mut talk = OnvifConversation::up(with_login());
    talk.session.request(rates(0.3, -0.2), Some(at(60_000)));
    assert_eq!(talk.run_until(50, OnvifConversation::is_turning), Some(5), "one way of 4 ms");
    for _ in 0..5_000 {
        talk.run_for(1);
        assert!(talk.is_turning(), "{:?}", talk.now);
    }
    assert_eq!(talk.camera.velocity(talk.now), SpeedShares::turning(0.3, -0.2));
    let since = talk.now;
    talk.session.request(VehicleRates::REST, None);
    assert_eq!(talk.run_until(50, |talk| !talk.is_turning()), Some(5));
    talk.run_for(3_000);
    let zeros = talk.commands_since(since);
    assert!((3..=12).contains(&zeros.len()), "{} zeros", zeros.len());
    assert!(zeros.iter().any(|ask| matches!(ask, Ask::Move { .. })), "{zeros:?}");
    assert!(zeros.iter().all(|ask| !ask.is_motion()));
    assert_eq!(talk.camera.refusals(), 0);
}

#[test]
fn the_zoom_moves_in_shares_of_its_full_speed_and_ends_with_the_other_axes() {
    let mut talk = OnvifConversation::up(camera());
    let zooming = |speed| rates(0.3, 0.0).zooming(speed);
    talk.session.request(zooming(-0.5), Some(at(60_000)));
    talk.run_for(50);
    assert_eq!(talk.camera.velocity(talk.now), SpeedShares { pan: 0.3, tilt: 0.0, zoom: -0.5 });
    talk.session.request(zooming(9.0), Some(at(60_000)));
    talk.run_for(50);
    assert_eq!(talk.camera.velocity(talk.now).zoom, 1.0);
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(50);
    assert_eq!(talk.camera.velocity(talk.now), SpeedShares::turning(0.3, 0.0));
    talk.session.request(zooming(0.1), Some(at(60_000)));
    talk.run_for(50);
    talk.session.request(VehicleRates::REST, None);
    talk.run_for(50);
    assert_eq!((talk.camera.velocity(talk.now), talk.camera.refusals()), (SpeedShares::default(), 0));
}

#[test]
fn a_camera_that_states_no_zoom_is_not_sent_any() {
    let full = FullSpeeds { pan: 1.0, tilt: 1.0, zoom: None };
    let mut talk = OnvifConversation::up(CameraSettings { full, ..camera() });
    talk.session.request(rates(0.3, 0.0).zooming(1.0), Some(at(60_000)));
    talk.run_for(50);
    assert_eq!((talk.camera.velocity(talk.now), talk.camera.refusals()), (SpeedShares::turning(0.3, 0.0), 0));
    assert_eq!(talk.zoom(), ZoomAbility::Absent);
    assert_eq!(OnvifConversation::up(camera()).zoom(), ZoomAbility::Present);
}

#[test]
fn a_camera_that_loses_its_profile_is_left_and_joined_anew_with_what_it_has_then() {
    let one = |token: &str| vec![(token.to_owned(), "main".to_owned())];
    let mut talk = OnvifConversation::up(CameraSettings { profiles: one("old"), ..camera() });
    let used = |talk: &OnvifConversation| {
        let used = talk.reports().iter().rev().find_map(|report| match report {
            Report::Equipment(used) => Some(used.name.to_string()),
            _ => None,
        });
        used.unwrap()
    };
    assert_eq!(used(&talk), "old of video source Source_1");
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(500);
    let exchanged = CameraSettings { profiles: one("new"), source: "Source_2".to_owned(), ..camera() };
    talk.camera.set_settings(exchanged);
    talk.run_for(500);
    assert_eq!(talk.session.link_state(), LinkState::Starting);
    assert!(talk.session.failure().unwrap().contains("no such token"), "{:?}", talk.session.failure());
    talk.run_for(6_000);
    assert!(!talk.is_turning());
    assert_eq!(
        (used(&talk), talk.session.link_state()),
        ("new of video source Source_2".to_owned(), LinkState::Up)
    );
}

#[test]
fn a_range_of_another_size_is_kept_to() {
    let mut talk = OnvifConversation::up(CameraSettings {
        full: FullSpeeds { pan: 8.0, tilt: 0.5, zoom: None },
        ..camera()
    });
    talk.session.request(rates(1.0, -0.5), Some(at(60_000)));
    talk.run_for(100);
    assert_eq!(
        (talk.camera.velocity(talk.now), talk.camera.refusals()),
        (SpeedShares::turning(1.0, -0.5), 0)
    );
}

#[test]
fn without_renewal_the_motion_ends_by_the_cameras_own_time_out() {
    for (timeouts, most_ms) in [((100, 60_000), 1_010), ((1_500, 60_000), 1_510), ((100, 700), 710)] {
        let (least, most) = timeouts;
        let timeouts = (Duration::from_millis(least), Duration::from_millis(most));
        let mut talk = OnvifConversation::up(CameraSettings { timeouts, ..camera() });
        talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
        talk.run_for(2_000);
        assert!(talk.is_turning());
        talk.is_cut = true;
        let ended = talk.run_until(3_000, |talk| !talk.is_turning()).unwrap();
        assert!(ended <= most_ms, "{ended} ms");
    }
}

#[test]
fn a_camera_that_ends_no_motion_soon_is_not_used() {
    let timeouts = (Duration::from_secs(10), Duration::from_secs(60));
    let settings = OnvifSettings { login: None, speeds: Some(speeds()), profile: None };
    let mut talk = OnvifConversation::new(CameraSettings { timeouts, ..camera() }, settings);
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(2_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::NoCamera));
    assert!(talk.session.failure().unwrap().contains("10 s"), "{:?}", talk.session.failure());
    assert_eq!(talk.commands_since(at(0)).len(), 0);
}

#[test]
fn the_chosen_media_profile_is_moved_and_one_that_is_not_there_is_no_camera() {
    let with = |profile: Option<&str>| {
        let profile = profile.map(str::to_owned);
        let settings = OnvifSettings { login: None, speeds: Some(speeds()), profile };
        let mut talk = OnvifConversation::new(camera(), settings);
        talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
        talk.run_for(2_000);
        talk
    };
    for (chosen, moved) in [(None, "Profile_1"), (Some("Profile_2"), "Profile_2"), (Some("sub"), "Profile_2")]
    {
        let talk = with(chosen);
        assert!(talk.is_turning());
        let is_of_it = |ask: &&Ask| match ask {
            Ask::Move { profile, .. } | Ask::Stop { profile } => profile == moved,
            _ => true,
        };
        assert!(talk.commands_since(at(0)).iter().all(is_of_it), "{chosen:?}");
    }
    for unknown in ["Fixed", "Profile_3", ""] {
        let talk = with(Some(unknown));
        assert_eq!(talk.acceptance(), Some(Acceptance::NoCamera));
        assert!(talk.session.failure().unwrap().contains("Profile_1, Profile_2"), "{unknown}");
        assert_eq!(talk.commands_since(at(0)).len(), 0);
    }
}

#[test]
fn a_camera_whose_speeds_were_not_measured_is_not_turned() {
    let mut talk =
        OnvifConversation::new(camera(), OnvifSettings { login: None, speeds: None, profile: None });
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(3_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::NotCalibrated));
    assert!(talk.commands_since(at(0)).iter().all(|ask| !ask.is_motion()));
    assert!(!talk.is_turning());
}

#[test]
fn one_kind_of_zero_stops_a_camera_that_ignores_the_other() {
    for faults in [
        CameraFaults { ignores_stops: true, ignores_timeouts: true, ..CameraFaults::default() },
        CameraFaults { ignores_zeros: true, ignores_timeouts: true, ..CameraFaults::default() },
    ] {
        let mut talk = OnvifConversation::up(camera());
        talk.camera.set_faults(faults);
        talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
        talk.run_for(1_000);
        talk.session.request(VehicleRates::REST, None);
        let ended = talk.run_until(500, |talk| !talk.is_turning());
        assert!(ended.is_some_and(|ms| ms <= 210), "{faults:?}: {ended:?}");
    }
}

#[test]
fn zeros_go_on_while_a_camera_that_was_turned_does_not_rest() {
    let mut talk = OnvifConversation::up(camera());
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    let deaf = CameraFaults {
        ignores_stops: true,
        ignores_zeros: true,
        ignores_timeouts: true,
        ..CameraFaults::default()
    };
    talk.camera.set_faults(deaf);
    talk.session.request(VehicleRates::REST, None);
    talk.run_for(10_000);
    let since = talk.now;
    talk.run_for(2_000);
    assert!(talk.commands_since(since).len() >= 10, "{:?}", talk.commands_since(since));
    talk.camera.set_faults(CameraFaults::default());
    assert!(talk.run_until(500, |talk| !talk.is_turning()).is_some());
}

#[test]
fn a_camera_that_another_client_turns_is_left_alone() {
    let mut talk = OnvifConversation::up(camera());
    talk.run_for(3_000);
    let since = talk.now;
    let mut other = OnvifConversation::up(camera());
    other.session.request(rates(0.2, 0.0), Some(at(60_000)));
    other.run_for(100);
    talk.camera = PtzCamera::clone(&other.camera);
    talk.camera.set_faults(CameraFaults { ignores_timeouts: true, ..CameraFaults::default() });
    talk.run_for(2_000);
    assert!(talk.is_turning());
    assert!(matches!(talk.session.rest_evidence(talk.now), RestEvidence::Moving { .. }));
    assert_eq!(talk.commands_since(since).len(), 0);
}

#[test]
fn old_cameras_and_those_without_a_position_are_stopped_too() {
    let old = CameraSettings { knows_services: false, tells_position: false, ..camera() };
    let mut talk = OnvifConversation::up(old);
    assert!(talk.sent.iter().any(|(_, ask)| *ask == Ask::Capabilities));
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    assert!(matches!(talk.session.rest_evidence(talk.now), RestEvidence::Moving { .. }));
    talk.session.close(talk.now);
    talk.run_until(2_500, |talk| talk.last == NextAction::Closed).unwrap();
    assert!(!talk.is_turning());
    assert_eq!(talk.session.rest_evidence(talk.now), RestEvidence::AtRest);
}

#[test]
fn a_refused_login_is_told_and_a_clock_that_jumps_is_followed() {
    let mut talk = OnvifConversation::up(with_login());
    talk.session.request(rates(0.3, 0.0), Some(at(60_000)));
    talk.run_for(1_000);
    talk.camera.set_faults(CameraFaults { clock_ahead_s: 7_200, ..CameraFaults::default() });
    talk.run_until(1_000, |talk| talk.acceptance() == Some(Acceptance::LoginRefused)).unwrap();
    assert!(talk.run_until(1_100, |talk| !talk.is_turning()).is_some(), "the motion ends by its time-out");
    assert!(talk.session.failure().unwrap().contains("not authorized"), "{:?}", talk.session.failure());
    // A new session asks for the camera's time anew.
    talk.run_until(7_000, |talk| talk.acceptance() == Some(Acceptance::Accepted)).unwrap();
    talk.camera.set_faults(CameraFaults { refuses_login: true, ..talk.camera.faults() });
    talk.run_until(7_000, |talk| talk.acceptance() == Some(Acceptance::LoginRefused)).unwrap();
}

#[test]
fn a_link_whose_zeros_are_refused_ends_at_once() {
    let mut talk = OnvifConversation::up(with_login());
    talk.camera.set_faults(CameraFaults { refuses_login: true, ..CameraFaults::default() });
    talk.session.close(talk.now);
    let ended = talk.run_until(2_500, |talk| talk.last == NextAction::Closed);
    assert!(ended.is_some_and(|ms| ms <= 50), "{ended:?}");
}

#[test]
fn a_camera_that_is_silent_is_reached_anew() {
    let mut talk = OnvifConversation::up(camera());
    talk.is_cut = true;
    talk.run_for(2_700);
    assert_eq!(talk.session.link_state(), LinkState::Up);
    assert!(talk.run_until(900, |talk| matches!(talk.last, NextAction::Reopen { .. })).is_some());
    talk.is_cut = false;
    talk.run_until(1_000, |talk| talk.session.link_state() == LinkState::Up).unwrap();
}

#[test]
fn what_is_nested_without_end_is_no_answer() {
    let depth = 40_000;
    for (open, close) in [("<s:Subcode>", "</s:Subcode>"), ("<a>", "</a>")] {
        let nested = open.repeat(depth) + &close.repeat(depth);
        let body =
            format!("<s:Envelope><s:Body><s:Fault><s:Code>{nested}</s:Code></s:Fault></s:Body></s:Envelope>");
        let refusal = barrelman_wire::onvif::refusal::Refusal::of(500, body.as_bytes()).unwrap();
        assert_eq!(refusal.said, Acceptance::Fault);
    }
    let bomb = "<!DOCTYPE x [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\
                <s:Envelope><s:Body><GetStreamUriResponse><Uri>&b;</Uri></GetStreamUriResponse></s:Body></s:Envelope>";
    assert!(soap::read::<barrelman_wire::onvif::answers::StreamUriBody>(bomb.as_bytes()).is_none());
}

/// The answers that a camera gives to the questions at the start.
fn answers() -> Vec<Vec<u8>> {
    let mut talk = OnvifConversation::up(with_login());
    let mut camera = PtzCamera::new(camera());
    talk.run_for(10);
    let mut caller = barrelman_wire::onvif::call::Caller::new(None, [0; 16]);
    let paths = barrelman_wire::onvif::joining::Paths::default();
    let mut messages: Vec<Vec<u8>> = Vec::new();
    for (_, ask) in talk.sent.drain(..) {
        let call = caller.call(ask, &paths, at(0));
        let message = barrelman_wire::http::HttpCall::body(&call).unwrap();
        messages.push(camera.answer(message.as_bytes(), (0.1, 0.2), false, at(0)).body.into_bytes());
    }
    messages
}

proptest! {
    #[test]
    fn no_answer_brings_the_session_down(
        cuts in prop::collection::vec((any::<u8>(), any::<u16>(), any::<u8>(), 200_u16..600), 0..60),
    ) {
        let answers = answers();
        let settings = OnvifSettings { login: Some(login()), speeds: Some(speeds()), profile: None };
        let mut session = OnvifSession::open(&settings, [3; 16], at(0));
        session.request(rates(0.3, 0.1), Some(at(60_000)));
        let mut ms = 0;
        for (which, cut, byte, status) in cuts {
            ms += 40;
            let mut out = Vec::new();
            session.poll(at(ms), &mut out);
            for request in out {
                let mut body = answers[usize::from(which) % answers.len()].clone();
                let place = usize::from(cut) % body.len();
                if byte == 0 { body.truncate(place) } else { body[place] = byte }
                let status = if byte % 2 == 0 { 200 } else { status };
                let received = Received::Answer { id: request.id, status, body };
                session.received(&received, at(ms), &mut |_| {});
            }
        }
        session.close(at(ms));
        let mut out = Vec::new();
        prop_assert!(!matches!(session.poll(at(ms + 5_000), &mut out), NextAction::WaitUntil(_)));
    }
}
