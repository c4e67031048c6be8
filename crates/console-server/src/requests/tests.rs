//! Requests of pages and programs, with the answers of a scripted session.

use super::super::in_memory::{InMemory, LIVE, block_on};
use barrelman_vocab::{LawId, MarkKind, NewDrive, Note, NoteRequest, Timestamp, WorldRequest};

use super::*;
use crate::operator::AnswerSlot;

const CONTROL: Role = Role::Control;
const WATCH: Role = Role::Watch;
const STOP: OperatorRequest = OperatorRequest::Stop(StopCause::Operator);

fn parsed(json: &str) -> Request {
    serde_json::from_str(json).unwrap_or_else(|error| panic!("{json}: {error}"))
}

/// A request of a program in its JSON form reaches the session as this.
#[track_caller]
fn check(json: &str, expected: SessionRequest) {
    let mut session = InMemory::new(LIVE);
    assert_eq!(session.request(CONTROL, None, parsed(json)), ACCEPTED, "{json}");
    assert_eq!(session.taken, [expected], "{json}");
}

/// A request of a program is refused for this reason, and does not reach the session.
#[track_caller]
fn check_refused(json: &str, reason: &str) {
    let mut session = InMemory::new(LIVE);
    let (answer, given) = session.request(CONTROL, None, parsed(json));
    let given = given.unwrap_or_default();
    assert_eq!(answer, AnswerKind::Refused, "{json}");
    assert!(given.contains(reason), "{json}: {given}");
    assert_eq!(session.taken, [], "{json}");
}

#[test]
fn each_request_reaches_the_session_in_its_own_words() {
    let pilot = SessionRequest::Pilot;
    check(r#"{"kind":"engage"}"#, pilot(OperatorRequest::Camera(CameraRequest::Engage)));
    check(r#"{"kind":"disengage"}"#, pilot(OperatorRequest::Camera(CameraRequest::Disengage)));
    check(r#"{"kind":"reject"}"#, pilot(OperatorRequest::Camera(CameraRequest::Reject)));
    check(r#"{"kind":"deselect"}"#, pilot(OperatorRequest::Camera(CameraRequest::Deselect)));
    let bounds = PixelBox { u: 10.5, v: -3.0, w: 40.0, h: 20.0 };
    let drawn = DrawnSelection { bounds, captured_ns: Timestamp::from_nanos(1_234_567_890_123) };
    check(
        r#"{"kind":"select","bounds":{"u":10.5,"v":-3,"w":40,"h":20},"captured_ns":1234567890123}"#,
        pilot(OperatorRequest::Camera(CameraRequest::Select(drawn))),
    );
    let nudge =
        |pan, tilt| pilot(OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan, tilt, zoom: 0.0 })));
    check(r#"{"kind":"nudge","pan":0.25,"tilt":-1}"#, nudge(0.25, -1.0));
    check(r#"{"kind":"nudge","pan":0,"tilt":1.0}"#, nudge(0.0, 1.0));
    let law = |law| pilot(OperatorRequest::Camera(CameraRequest::Law { law }));
    check(r#"{"kind":"law","law":"schema"}"#, law(LawId::Schema));
    check(r#"{"kind":"law","law":"intermittent"}"#, law(LawId::Intermittent));
    check(r#"{"kind":"law","law":"minimum-energy"}"#, law(LawId::MinimumEnergy));
    check(r#"{"kind":"law","law":"time-fuel"}"#, law(LawId::TimeFuel));
    check(r#"{"kind":"law","law":"eco"}"#, law(LawId::Eco));
    check(r#"{"kind":"release-vessel"}"#, pilot(OperatorRequest::Vessel(VesselRequest::ReleaseVessel)));
    let drawn = |kind| DrawnMark {
        mark: kind,
        at: PixelPoint { u: 4.5, v: -1.0 },
        captured_ns: Timestamp::from_nanos(17),
    };
    for (name, kind) in [
        ("place", MarkKind::Place),
        ("person", MarkKind::Person),
        ("way-point", MarkKind::WayPoint),
        ("forbidden", MarkKind::Forbidden),
        ("home", MarkKind::Home),
    ] {
        let json = format!(r#"{{"kind":"mark","mark":"{name}","at":{{"u":4.5,"v":-1}},"captured_ns":17}}"#);
        check(&json, pilot(OperatorRequest::Vessel(VesselRequest::Mark(drawn(kind)))));
    }
    let moved = MovedMark { id: 2, at: PixelPoint { u: 1.0, v: 2.0 }, captured_ns: Timestamp::from_nanos(9) };
    check(
        r#"{"kind":"move-mark","id":2,"at":{"u":1,"v":2},"captured_ns":9}"#,
        pilot(OperatorRequest::Vessel(VesselRequest::MoveMark(moved))),
    );
    check(r#"{"kind":"unmark","id":3}"#, pilot(OperatorRequest::Vessel(VesselRequest::Unmark { id: 3 })));
    check(r#"{"kind":"unmark-all"}"#, pilot(OperatorRequest::Vessel(VesselRequest::UnmarkAll)));
    check(r#"{"kind":"next-mark"}"#, pilot(OperatorRequest::Vessel(VesselRequest::NextMark)));
    check(
        r#"{"kind":"stop-vessel"}"#,
        pilot(OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator })),
    );
    check(r#"{"kind":"pause"}"#, SessionRequest::World(WorldRequest::Pause));
    check(r#"{"kind":"resume"}"#, SessionRequest::World(WorldRequest::Resume));
    let note = |text: &str| {
        SessionRequest::Note(NoteRequest::Note(Note { text: text.to_owned().try_into().unwrap() }))
    };
    check(r#"{"kind":"note","text":"smoke at the pier"}"#, note("smoke at the pier"));
    check(r#"{"kind":"note"}"#, note(""));
    let wanted = NewDrive { scenario: "rescue".to_owned(), seed: u64::MAX };
    check(
        r#"{"kind":"new-drive","scenario":"rescue","seed":18446744073709551615}"#,
        SessionRequest::World(WorldRequest::NewDrive(wanted)),
    );
}

#[test]
fn the_boat_is_commanded_from_a_page_only() {
    let steer = VesselRequest::Steer(VesselCommand { throttle: 1.0, rudder: 0.5 });
    for request in [steer, VesselRequest::Guide, VesselRequest::GoHome].map(OperatorRequest::Vessel) {
        let mut session = InMemory::new(LIVE);
        let (answer, reason) = session.request(CONTROL, None, request);
        assert_eq!(answer, AnswerKind::Refused);
        assert!(reason.unwrap_or_default().contains("only a page on a socket"), "{request:?}");
        session.join("a", CONTROL);
        assert_eq!(session.request(CONTROL, Some(0), request).0, AnswerKind::Accepted);
        assert_eq!(session.taken, [SessionRequest::Pilot(request)]);
    }
}

#[test]
fn values_without_sense_are_refused_with_the_reason() {
    for (w, h) in [("0", "5"), ("5", "0"), ("-5", "5"), ("5", "-0.0")] {
        let bounds = format!(r#"{{"u":0,"v":0,"w":{w},"h":{h}}}"#);
        let json = format!(r#"{{"kind":"select","bounds":{bounds},"captured_ns":0}}"#);
        check_refused(&json, "the box must have");
    }
    for (first, second) in [("1.01", "0"), ("0", "-1.01"), ("1e300", "0"), ("-100", "100")] {
        let range = "numbers from -1 to 1";
        check_refused(&format!(r#"{{"kind":"nudge","pan":{first},"tilt":{second}}}"#), range);
        let mut session = InMemory::new(LIVE);
        session.join("a", CONTROL);
        let helm = parsed(&format!(r#"{{"kind":"steer","throttle":{first},"rudder":{second}}}"#));
        let (answer, reason) = session.request(CONTROL, Some(0), helm);
        assert_eq!((answer, session.taken.len()), (AnswerKind::Refused, 0));
        assert!(reason.unwrap_or_default().contains(range));
    }
}

#[test]
fn numbers_that_json_cannot_carry_are_refused_too() {
    let captured_ns = Timestamp::ZERO;
    let select = |[u, v, w, h]: [f64; 4]| -> OperatorRequest {
        CameraRequest::Select(DrawnSelection { bounds: PixelBox { u, v, w, h }, captured_ns }).into()
    };
    let nudge = |pan, tilt| CameraRequest::Nudge(Nudge { pan, tilt, zoom: 0.0 }).into();
    let steer = |throttle, rudder| VesselRequest::Steer(VesselCommand { throttle, rudder }).into();
    let nan = f64::NAN;
    for request in [
        select([nan, 0.0, 1.0, 1.0]),
        select([0.0, f64::INFINITY, 1.0, 1.0]),
        select([0.0, 0.0, f64::INFINITY, 1.0]),
        select([0.0, 0.0, 1.0, nan]),
        nudge(nan, 0.0),
        nudge(0.0, f64::NEG_INFINITY),
        steer(nan, 0.0),
        steer(0.0, nan),
    ] {
        let mut session = InMemory::new(LIVE);
        assert_eq!(session.request(CONTROL, None, request).0, AnswerKind::Refused, "{request:?}");
        assert_eq!(session.taken, [], "{request:?}");
    }
}

/// Who makes a request: page 0 controls, page 1 may control, page 2 watches.
#[derive(Debug, Clone, Copy)]
enum Who {
    Holder,
    Other,
    Viewer,
    /// A page that was dropped.
    Dropped,
    Program,
    ViewingProgram,
}

use Who::{Dropped, Holder, Other, Program, Viewer, ViewingProgram};

/// With three pages connected, a request gets this answer; an empty reason: accepted.
#[track_caller]
fn check_from(from: Who, request: impl Into<Request>, reason: &str) {
    let request = request.into();
    let mut session = InMemory::new(LIVE);
    for (name, role) in [("a", CONTROL), ("b", CONTROL), ("c", WATCH)] {
        session.join(name, role);
    }
    let (role, client) = match from {
        Holder => (CONTROL, Some(0)),
        Other => (CONTROL, Some(1)),
        Viewer => (WATCH, Some(2)),
        Dropped => (CONTROL, Some(7)),
        Program => (CONTROL, None),
        ViewingProgram => (WATCH, None),
    };
    let (answer, given) = session.request(role, client, request.clone());
    let expected = if reason.is_empty() { AnswerKind::Accepted } else { AnswerKind::Refused };
    assert_eq!(answer, expected, "{from:?} {request:?}: {given:?}");
    assert!(given.unwrap_or_default().contains(reason), "{from:?} {request:?}");
    let is_refused = answer == AnswerKind::Refused;
    assert!(!is_refused || session.taken.is_empty(), "a refused request does not reach the session");
}

#[test]
fn a_session_is_commanded_from_the_control_seat_only() {
    let bounds = PixelBox { u: 1.0, v: 2.0, w: 3.0, h: 4.0 };
    let captured_ns = Timestamp::from_nanos(5);
    let requests: [Request; 12] = [
        CameraRequest::Engage.into(),
        CameraRequest::Disengage.into(),
        CameraRequest::Reject.into(),
        CameraRequest::Deselect.into(),
        CameraRequest::Select(DrawnSelection { bounds, captured_ns }).into(),
        CameraRequest::Nudge(Nudge::default()).into(),
        CameraRequest::Law { law: LawId::Eco }.into(),
        VesselRequest::Steer(VesselCommand::NEUTRAL).into(),
        VesselRequest::ReleaseVessel.into(),
        WorldRequest::Pause.into(),
        WorldRequest::Resume.into(),
        WorldRequest::NewDrive(NewDrive { scenario: "rescue".to_owned(), seed: 7 }).into(),
    ];
    for request in requests {
        check_from(Holder, request.clone(), "");
        check_from(Other, request.clone(), "another page is in control: ask for the control, or take it");
        check_from(Viewer, request.clone(), "this token may only watch and stop");
        check_from(Dropped, request.clone(), "another page is in control");
        check_from(Program, request.clone(), "a page is in control");
        check_from(ViewingProgram, request, "this token may only watch and stop");
    }
}

#[test]
fn everyone_who_has_the_token_for_control_marks_a_moment() {
    let note = || NoteRequest::Note(Note::default());
    for from in [Holder, Other, Program] {
        check_from(from, note(), "");
    }
    for from in [Viewer, ViewingProgram] {
        check_from(from, note(), "this token may only watch and stop");
    }
}

#[test]
fn everybody_can_stop() {
    for from in [Holder, Other, Viewer, Dropped, Program, ViewingProgram] {
        check_from(from, STOP, "");
    }
}

#[test]
fn control_moves_between_pages_that_may_control() {
    let (take, ask) = (SeatRequest::TakeControl, SeatRequest::AskControl);
    let give = |client| SeatRequest::GiveControl { client };
    let may_watch = "this token may only watch";
    for request in [take, ask, give(0)] {
        check_from(Viewer, request, may_watch);
        check_from(ViewingProgram, request, may_watch);
    }
    check_from(Program, take, "");
    check_from(Program, ask, "");
    check_from(Program, give(0), "a program is not in control");
    check_from(Program, SeatRequest::ReleaseControl, "a program is not in control");
    check_from(Viewer, SeatRequest::ReleaseControl, may_watch);
    check_from(Holder, SeatRequest::ReleaseControl, "");
    check_from(Other, SeatRequest::ReleaseControl, "only who is in control");
    check_from(Holder, take, "");
    check_from(Holder, ask, "");
    check_from(Holder, give(1), "");
    check_from(Holder, give(0), "");
    check_from(Holder, give(2), "that page may only watch");
    check_from(Holder, give(9), "that page is not connected");
    check_from(Other, take, "");
    check_from(Other, ask, "");
    check_from(Other, give(1), "only the page in control can give the control");
    check_from(Dropped, take, "may only watch");
}

#[test]
fn pages_are_told_who_asks_for_takes_and_gives_the_control() {
    let mut session = InMemory::new(LIVE);
    let (first, second) = (session.join("a", CONTROL), session.join("b", CONTROL));
    let seat = session.console.seat_changes.subscribe();
    session.request(CONTROL, Some(second), SeatRequest::AskControl);
    assert_eq!((seat.borrow().holder, seat.borrow().asking.clone()), (Some(first), vec![second]));
    session.request(CONTROL, Some(first), SeatRequest::GiveControl { client: second });
    assert_eq!((seat.borrow().holder, seat.borrow().asking.clone()), (Some(second), vec![]));
    session.request(CONTROL, Some(first), SeatRequest::TakeControl);
    assert_eq!(seat.borrow().holder, Some(first));
    session.request(CONTROL, Some(second), SeatRequest::GiveControl { client: second });
    let notices = ["page 1 asks for the control", "page 0 gave the control away", "page 0 took the control"];
    assert_eq!(session.logged("control"), notices, "a refused request is no change");
}

#[test]
fn a_program_may_command_while_no_page_is_there() {
    let mut session = InMemory::new(LIVE);
    let watcher = session.join("w", WATCH);
    assert_eq!(session.request(CONTROL, None, CameraRequest::Engage), ACCEPTED);
    let page = session.join("a", CONTROL);
    assert_eq!(session.request(CONTROL, None, CameraRequest::Engage).0, AnswerKind::Refused);
    session.console.with_seats(|seats| seats.leave(page, session.console.time.clock()));
    let reply = session.request(CONTROL, None, CameraRequest::Engage);
    assert_eq!(reply.0, AnswerKind::Refused, "the seat of a lost page is kept for a reload");
    assert_eq!(session.request(WATCH, Some(watcher), STOP), ACCEPTED);
}

#[test]
fn a_program_asks_for_takes_and_gives_up_the_control() {
    let mut session = InMemory::new(LIVE);
    let page = session.join("a", CONTROL);
    let seat = session.console.seat_changes.subscribe();
    session.request(CONTROL, None, SeatRequest::AskControl);
    let program = seat.borrow().program.unwrap();
    assert_eq!((seat.borrow().holder, seat.borrow().asking.clone()), (Some(page), vec![program]));
    session.request(CONTROL, Some(page), SeatRequest::GiveControl { client: program });
    assert_eq!(seat.borrow().holder, Some(program));
    assert_eq!(session.request(CONTROL, None, CameraRequest::Engage), ACCEPTED);
    let reason = session.request(CONTROL, Some(page), CameraRequest::Engage).1.unwrap_or_default();
    assert!(reason.starts_with("a program is in control"), "{reason}");
    let reason = session.request(CONTROL, None, VesselRequest::Guide).1.unwrap_or_default();
    assert!(reason.contains("only a page on a socket"), "{reason}");
    assert_eq!(session.request(CONTROL, None, SeatRequest::ReleaseControl), ACCEPTED);
    assert_eq!(seat.borrow().holder, None);
    session.request(CONTROL, Some(page), SeatRequest::TakeControl);
    session.request(CONTROL, None, SeatRequest::TakeControl);
    assert_eq!(seat.borrow().holder, Some(program));
    assert_eq!(session.logged("control").last().map(String::as_str), Some("a program took the control"));
}

#[test]
fn the_answer_is_that_of_the_session() {
    for (given, expected) in [
        (Answer::ACCEPTED, (AnswerKind::Accepted, None)),
        (
            Answer::Accepted(Some("following".to_owned())),
            (AnswerKind::Accepted, Some("following".to_owned())),
        ),
        (Answer::Refused("stopped".to_owned()), (AnswerKind::Refused, Some("stopped".to_owned()))),
        (Answer::Superseded("later".to_owned()), (AnswerKind::Superseded, Some("later".to_owned()))),
    ] {
        let mut session = InMemory::new(LIVE);
        session.answer = given;
        assert_eq!(session.request(CONTROL, None, CameraRequest::Engage), expected);
    }
}

#[test]
fn a_request_that_the_session_never_took_is_refused_at_its_end() {
    let session = InMemory::new(LIVE);
    let (slot, receiver) = AnswerSlot::new();
    drop(slot);
    let reply = block_on(answer(&session.console, Pending::Submitted(receiver)));
    assert_eq!(reply, refused("the session has ended"));
}

#[test]
fn a_stop_supersedes_the_requests_that_wait() {
    let mut session = InMemory::new(LIVE);
    let from = Requester { role: CONTROL, client: None, stops_taken: None };
    let waiting = begin_request(&session.console, from, CameraRequest::Engage.into());
    let stop = begin_request(&session.console, from, STOP.into());
    session.take_requests();
    assert_eq!(session.taken, [], "the pilot is not engaged after the stop");
    let superseded = (AnswerKind::Superseded, Some("stopped".to_owned()));
    assert_eq!(block_on(answer(&session.console, waiting)), superseded);
    assert_eq!(block_on(answer(&session.console, stop)), ACCEPTED);
}

#[test]
fn repeated_stops_are_all_acknowledged_by_one_step() {
    let mut session = InMemory::new(LIVE);
    let from = Requester { role: WATCH, client: None, stops_taken: None };
    let stops = [(); 3].map(|()| begin_request(&session.console, from, STOP.into()));
    session.take_requests();
    assert_eq!(session.publisher.newest().steps, 1);
    for stop in stops {
        assert_eq!(block_on(answer(&session.console, stop)), ACCEPTED);
    }
}

#[test]
fn a_stop_that_is_pressed_again_is_not_acknowledged_by_the_step_before() {
    let mut session = InMemory::new(LIVE);
    assert_eq!(session.request(WATCH, None, STOP), ACCEPTED);
    let from = Requester { role: WATCH, client: None, stops_taken: None };
    let second = begin_request(&session.console, from, STOP.into());
    assert!(matches!(second, Pending::Stop(2)), "{second:?}");
    let InMemory { console, publisher, .. } = session;
    drop(publisher);
    assert_eq!(block_on(answer(&console, second)).0, AnswerKind::Refused);
}

#[test]
fn what_was_asked_for_before_a_stop_and_comes_after_it_begins_no_motion() {
    let mut session = InMemory::new(LIVE);
    session.join("a", CONTROL);
    let stopper = Requester { role: WATCH, client: None, stops_taken: None };
    // Not taken yet, or taken and not published yet.
    drop(begin_request(&session.console, stopper, STOP.into()));
    let late = Requester { role: CONTROL, client: Some(0), stops_taken: Some(0) };
    let engaging = begin_request(&session.console, late, CameraRequest::Engage.into());
    assert!(matches!(engaging, Pending::Answered(_)), "{engaging:?}");
    session.take_requests();
    let mut ask = |stops_taken, request: OperatorRequest| {
        let from = Requester { role: CONTROL, client: Some(0), stops_taken };
        let pending = begin_request(&session.console, from, request.into());
        session.take_requests();
        block_on(answer(&session.console, pending))
    };
    for request in [
        CameraRequest::Engage.into(),
        CameraRequest::Search.into(),
        OperatorRequest::Vessel(VesselRequest::Guide),
        OperatorRequest::Vessel(VesselRequest::GoHome),
    ] {
        assert_eq!(ask(Some(0), request), refused("a stop came in the meantime: ask again"));
        assert_eq!(ask(Some(1), request), ACCEPTED);
        assert_eq!(ask(None, request), ACCEPTED, "a client that does not say");
    }
    assert_eq!(ask(Some(0), CameraRequest::Disengage.into()), ACCEPTED);
}
