//! What the console does when the controlling page is gone, on a console without a server; and the end of a
//! connection of which only the head of a request comes.

use std::io::{Read as _, Write as _};

use barrelman_pilot::{Mode, Outcome, VesselMode, VesselOutcome};
use barrelman_vocab::Timestamp;

use super::super::access::Role;
use super::super::in_memory::{InMemory, LIVE, Setup};
use super::super::on_lost::OnConsoleLost;
use super::super::seats::ClientId;
use super::super::tokens::KeptTokens;
use super::*;
use crate::test_scenes::{at, idle};

/// The console's routes without TLS.
fn answering(session: &InMemory) -> Answering {
    Answering { router: routes::router(Arc::clone(&session.console)), https: None, clock: Clock::start() }
}

/// All that a client hears that sends this and then waits until its connection is ended.
fn heard(sent: String) -> String {
    let session = InMemory::new(LIVE);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let address = listener.local_addr().unwrap();
    let client = move || {
        let mut stream = std::net::TcpStream::connect(address).unwrap();
        stream.write_all(sent.as_bytes()).unwrap();
        let mut heard = String::new();
        stream.read_to_string(&mut heard).unwrap();
        heard
    };
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(async {
        tokio::select! {
            served = serve(listener, answering(&session)) => panic!("{served:?}"),
            heard = tokio::task::spawn_blocking(client) => heard.unwrap(),
        }
    })
}

#[test]
fn a_request_without_a_token_and_without_its_body_holds_no_connection() {
    for (line, status) in
        [("POST /api/v1/requests", 401), ("POST /api/v1/login", 401), ("GET /", 200), ("PUT /healthz", 405)]
    {
        let heard = heard(format!(
            "{line} HTTP/1.1\r\nHost: 127.0.0.1:8480\r\nContent-Type: application/json\r\nContent-Length: 100\r\n\r\n"
        ));
        assert!(heard.starts_with(&format!("HTTP/1.1 {status} ")), "{line}: {heard}");
    }
}

/// What a client hears that connects after `first` have connected and wait, each having sent this.
fn heard_after(first: usize, sent_first: &'static str, sent: String) -> String {
    let session = InMemory::new(LIVE);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let address = listener.local_addr().unwrap();
    let client = move || {
        let connect = |sent: &str| {
            let mut stream = std::net::TcpStream::connect(address).unwrap();
            stream.write_all(sent.as_bytes()).unwrap();
            stream
        };
        let _waiting: Vec<_> = (0..first).map(|_| connect(sent_first)).collect();
        let mut heard = String::new();
        connect(&sent).read_to_string(&mut heard).unwrap();
        heard
    };
    runtime().unwrap().block_on(async {
        tokio::select! {
            served = serve(listener, answering(&session)) => panic!("{served:?}"),
            heard = tokio::task::spawn_blocking(client) => heard.unwrap(),
        }
    })
}

#[test]
fn connections_that_show_no_token_keep_nobody_out() {
    let ask = "GET /api/v1/access HTTP/1.1\r\nHost: 127.0.0.1:8480\r\nConnection: close\r\n\
               Authorization: Bearer control-0123456789\r\n\r\n";
    for waits_with in ["", "GET / HT", "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:8480\r\n"] {
        let heard = heard_after(300, waits_with, ask.to_owned());
        assert!(heard.starts_with("HTTP/1.1 200 "), "{waits_with:?}: {heard}");
    }
}

/// A page was lost at this time.
fn lose_at(session: &InMemory, id: ClientId, lost: Timestamp) {
    session.console.with_seats(|seats| seats.leave(id, lost));
    session.console.publish_seats();
}

/// A page was lost long ago.
fn lose(session: &InMemory, id: ClientId) {
    lose_at(session, id, Timestamp::ZERO);
}

#[test]
fn a_lost_page_leaves_the_camera_engaged_with_a_warning() {
    for (mode, text) in [
        (Mode::Servoing, "the controlling page is gone; the camera stays engaged"),
        (Mode::Idle, "the controlling page is gone"),
    ] {
        let mut session = InMemory::new(LIVE);
        let page = session.join("a", Role::Control);
        session.step(&Outcome { mode, ..idle(at(0)) });
        lose(&session, page);
        session.console.expire_seats();
        assert_eq!(session.logged("console-lost"), [text]);
        assert_eq!(session.console.gateway.stop_latch().pending(), None);
    }
}

#[test]
fn a_lost_page_stops_the_camera_where_the_session_says_so() {
    let session = InMemory::new(Setup { on_lost: OnConsoleLost::Stop, ..LIVE });
    let page = session.join("a", Role::Control);
    lose(&session, page);
    session.console.expire_seats();
    assert_eq!(session.logged("console-lost"), ["the controlling page is gone: stopped"]);
    assert_eq!(session.console.gateway.stop_latch().pending(), Some(1));
    session.console.expire_seats();
    assert_eq!(session.console.gateway.stop_latch().pending(), Some(1), "once for each loss");
}

#[test]
fn a_page_that_was_lost_just_now_has_time_to_come_back() {
    let session = InMemory::new(Setup { on_lost: OnConsoleLost::Stop, ..LIVE });
    let page = session.join("a", Role::Control);
    // However long this test takes, the time to come back has not passed.
    lose_at(&session, page, session.console.time.clock().plus(Duration::from_secs(3600)));
    session.console.expire_seats();
    let seat = session.console.seat_changes.borrow().clone();
    assert_eq!((seat.holder, seat.holder_connected), (Some(page), false));
    assert_eq!(session.console.gateway.stop_latch().pending(), None);
    assert_eq!(session.join("a", Role::Control), page + 1);
    assert!(session.console.seat_changes.borrow().holder_connected);
}

#[test]
fn the_loop_is_told_when_the_page_in_control_is_gone_and_when_one_has_come() {
    let session = InMemory::new(LIVE);
    let page = session.join("a", Role::Control);
    lose(&session, page);
    assert!(!session.is_console_lost());
    session.console.expire_seats();
    assert!(session.is_console_lost());
    session.join("w", Role::Watch);
    assert!(session.is_console_lost(), "a watcher does not control");
    session.join("b", Role::Control);
    assert!(!session.is_console_lost());
}

#[test]
fn a_page_that_is_gone_for_a_short_time_keeps_its_cookie_when_tokens_are_renewed_by_age() {
    let session = InMemory::new(LIVE);
    let access = &session.console.access;
    let cookie = access.new_cookie(Role::Control).unwrap();
    let pass = access.pass(None, cookie.split(';').next()).unwrap();
    for _ in 0..2 {
        let id = session.console.join("a", pass.clone());
        assert!(session.console.pass_of_page(id).is_some());
        session.console.leave(id);
        assert!(session.console.pass_of_page(id).is_none());
    }
    let in_seconds = |seconds| session.console.time.clock().plus(Duration::from_secs(seconds));
    assert_eq!(session.console.passes_of_pages(in_seconds(590)), [pass]);
    assert_eq!(session.console.passes_of_pages(in_seconds(600)), []);
}

#[test]
fn tokens_are_renewed_by_age_only_while_neither_camera_nor_boat_moves() {
    let kept = KeptTokens { file: None, max_age: Some(Duration::ZERO) };
    let mut session = InMemory::with_kept(LIVE, kept);
    let vessel = |mode| VesselOutcome { mode, ..idle(at(0)).vessel };
    for (mode, boat, is_renewed) in [
        (Mode::Idle, VesselMode::Absent, true),
        (Mode::Idle, VesselMode::Neutral, true),
        (Mode::Servoing, VesselMode::Absent, false),
        (Mode::Idle, VesselMode::Guided, false),
    ] {
        session.step(&Outcome { mode, vessel: vessel(boat), ..idle(at(0)) });
        let now = session.console.time.clock();
        assert_eq!(session.console.token_renewal(now).unwrap() <= now, is_renewed, "{mode:?} {boat:?}");
    }
}

#[test]
fn a_session_without_a_page_is_not_a_lost_page() {
    let session = InMemory::new(Setup { on_lost: OnConsoleLost::Stop, ..LIVE });
    session.console.expire_seats();
    let watcher = session.join("w", Role::Watch);
    lose(&session, watcher);
    session.console.expire_seats();
    assert_eq!(session.logged("console-lost"), [""; 0]);
    assert_eq!(session.console.gateway.stop_latch().pending(), None);
}

#[test]
fn the_first_message_tells_a_page_what_it_may_do_and_what_it_looks_at() {
    let session = InMemory::new(LIVE);
    for (role, may_control) in [(Role::Control, true), (Role::Watch, false)] {
        let hello = serde_json::to_value(session.console.hello(5, role)).unwrap();
        assert_eq!((hello["client"].as_u64(), hello["may_control"].as_bool()), (Some(5), Some(may_control)));
        assert_eq!((&hello["command"], &hello["source"]), (&"run".into(), &"rtsp://camera/main".into()));
        assert_eq!(hello["link"], serde_json::Value::Null, "a dry run has no link");
        assert_eq!(hello["on_console_lost"], "stay");
        assert_eq!(
            hello["laws"],
            serde_json::json!(["minimum-energy", "time-fuel", "eco", "intermittent", "schema"])
        );
    }
}
