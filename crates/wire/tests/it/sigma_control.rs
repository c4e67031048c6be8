//! Who controls a Sigma, and its tokens.

use barrelman_vocab::ZoomRate;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::LinkState;
use barrelman_wire::fotokite_sigma::{Call, FotokiteSigmaSession};
use barrelman_wire::http::{HttpCall as _, Lane};
use barrelman_wire::{LinkHistory, NextAction, Session as _};

use crate::sigma_conversation::{Conversation, at, rates};
use crate::talk::Talk as _;

#[test]
fn the_control_is_asked_for_at_the_start_and_kept() {
    let mut talk = Conversation::up();
    for _ in 0..60 {
        talk.run_for(1_000);
        assert!(talk.sigma.is_controlled(talk.now));
    }
    let asked = talk.sent.iter().filter(|(_, request)| request.call == Call::RequestControl).count();
    assert!((20..=22).contains(&asked), "{asked} times in a minute");
}

#[test]
fn a_lost_request_for_the_control_does_not_lose_it() {
    let mut talk = Conversation::up();
    talk.hung = vec![(Lane::Control, false)];
    talk.run_for(6_000);
    talk.hung.clear();
    for _ in 0..10 {
        talk.run_for(1_000);
        assert!(talk.sigma.is_controlled(talk.now));
        assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
    }
}

#[test]
fn a_session_waits_in_the_queue_at_its_start_and_gets_the_control_when_it_is_given_up() {
    let mut talk = Conversation::new();
    talk.sigma.other_client_takes();
    talk.run_for(20_000);
    assert_eq!(talk.session.link_state(), LinkState::Up);
    assert_eq!(talk.acceptance(), Some(Acceptance::Queued));
    assert_eq!(talk.commands_since(at(0)), 0, "no command while another client controls");
    talk.sigma.other_client_releases(talk.now);
    talk.run_for(4_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
}

#[test]
fn control_that_is_taken_in_mid_motion_is_yielded_until_the_operator_engages() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(600_000)));
    talk.run_for(1_000);
    talk.sigma.other_client_takes();
    talk.run_for(200);
    assert_eq!(talk.acceptance(), Some(Acceptance::OtherClient), "told by the refused renewal");
    let since = talk.now;
    talk.run_for(30_000);
    assert_eq!(talk.commands_since(since), 0);
    let asked = |talk: &Conversation| {
        talk.sent
            .iter()
            .filter(|(when, request)| *when > since && request.call == Call::RequestControl)
            .count()
    };
    assert_eq!(asked(&talk), 0, "nobody asked for the control");
    talk.sigma.other_client_releases(talk.now);
    talk.run_for(5_000);
    assert!(!talk.sigma.is_controlled(talk.now), "free control is not taken unasked");
    talk.session.take_control(talk.now);
    talk.run_for(1_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
}

#[test]
fn control_that_is_taken_at_rest_is_found_by_the_renewal_and_the_wish_is_withdrawn() {
    let mut talk = Conversation::up();
    talk.sigma.other_client_takes();
    talk.run_for(4_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::OtherClient));
    talk.sigma.other_client_releases(talk.now);
    talk.run_for(1_000);
    assert!(!talk.sigma.is_controlled(talk.now), "the wish of the renewal was withdrawn");
}

#[test]
fn take_control_waits_in_the_queue_and_never_overrides() {
    let mut talk = Conversation::up();
    talk.sigma.other_client_takes();
    talk.run_for(4_000);
    talk.session.take_control(talk.now);
    talk.run_for(70_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::Queued));
    assert!(talk.sent.iter().all(|(_, request)| !request.call.path().contains("override")));
    talk.sigma.other_client_releases(talk.now);
    talk.run_for(4_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
}

#[test]
fn a_wrong_token_is_told_and_ends_the_session_after_a_while() {
    let mut talk = Conversation::new();
    talk.token = "wrong";
    talk.run_for(100);
    assert_eq!(talk.acceptance(), Some(Acceptance::TokenRefused));
    let sent = talk.sent.len();
    let ended = talk.run_until(6_000, |talk| matches!(talk.last, NextAction::Reopen { .. })).unwrap();
    assert!(ended >= 4_800, "{ended} ms: no hammering");
    assert_eq!(talk.sent.len(), sent, "nothing more is asked with a refused token");
}

#[test]
fn a_token_that_expires_in_mid_motion_ends_it() {
    let mut talk = Conversation::up();
    talk.session.request(rates(10.0, 0.0), Some(at(600_000)));
    talk.run_for(1_000);
    talk.sigma.set_expired(true);
    talk.run_for(460);
    assert!(talk.turning().is_rest());
    assert_eq!(talk.acceptance(), Some(Acceptance::TokenRefused));
}

#[test]
fn a_token_that_may_only_read_is_told_at_once() {
    let mut talk = Conversation::new();
    talk.token = "read";
    talk.run_for(1_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::TokenRefused));
    assert_eq!(talk.commands_since(at(0)), 0);
}

#[test]
fn control_that_another_took_stays_with_it_over_a_gap() {
    let mut talk = Conversation::up();
    talk.sigma.other_client_takes();
    talk.run_for(4_000);
    assert_eq!(talk.acceptance(), Some(Acceptance::OtherClient));
    talk.has_socket = false;
    let lanes = [Lane::Stop, Lane::Turn, Lane::Control, Lane::Camera, Lane::State, Lane::Socket];
    talk.hung = lanes.map(|lane| (lane, false)).into();
    talk.run_until(20_000, |talk| matches!(talk.last, NextAction::Reopen { .. })).expect("silent");
    let history = LinkHistory { is_anothers: talk.session.is_anothers(), ..LinkHistory::default() };
    talk.session = FotokiteSigmaSession::open(None, ZoomRate::from_per_second(0.3), talk.now);
    talk.session.resume(history);
    talk.hung.clear();
    talk.has_socket = true;
    talk.sigma.other_client_releases(talk.now);
    let since = talk.now;
    let asked = |talk: &Conversation| {
        let is_new = |(when, request): &&(_, barrelman_wire::http::Request<Call>)| {
            *when > since && request.call == Call::RequestControl
        };
        talk.sent.iter().filter(is_new).count()
    };
    talk.run_for(5_000);
    assert_eq!((asked(&talk), talk.session.link_state()), (0, LinkState::Up));
    talk.session.take_control(talk.now);
    talk.run_for(1_000);
    assert!(asked(&talk) > 0 && talk.sigma.is_controlled(talk.now));
}
