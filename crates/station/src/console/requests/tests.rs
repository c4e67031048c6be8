//! Requests of pages and programs, with the answers of a scripted session.

use super::super::in_memory::{InMemory, LIVE, block_on};
use super::*;
use crate::operator::AnswerSlot;

const CONTROL: Role = Role::Control;
const WATCH: Role = Role::Watch;

fn parsed(json: &str) -> ConsoleRequest {
    serde_json::from_str(json).unwrap_or_else(|error| panic!("{json}: {error}"))
}

/// A request of a program in its JSON form reaches the session as this.
#[track_caller]
fn check(json: &str, expected: Request) {
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
    let pilot = Request::Pilot;
    check(r#"{"kind":"engage"}"#, pilot(OperatorRequest::Engage));
    check(r#"{"kind":"disengage"}"#, pilot(OperatorRequest::Disengage));
    check(r#"{"kind":"reject"}"#, pilot(OperatorRequest::Reject));
    check(r#"{"kind":"deselect"}"#, pilot(OperatorRequest::Deselect));
    let bounds = PixelBox { u: 10.5, v: -3.0, w: 40.0, h: 20.0 };
    let drawn = DrawnSelection { bounds, captured: Timestamp::from_nanos(1_234_567_890_123) };
    check(
        r#"{"kind":"select","box":[10.5,-3,40,20],"captured_ns":1234567890123}"#,
        pilot(OperatorRequest::SelectOn(drawn)),
    );
    let nudge = |pan, tilt| pilot(OperatorRequest::Nudge(Nudge { pan, tilt }));
    check(r#"{"kind":"nudge","pan":0.25,"tilt":-1}"#, nudge(0.25, -1.0));
    check(r#"{"kind":"nudge","pan":0,"tilt":1.0}"#, nudge(0.0, 1.0));
    let law = |law| pilot(OperatorRequest::ChangeLaw(law));
    check(r#"{"kind":"law","law":"schema"}"#, law(LawId::MotorSchema));
    check(r#"{"kind":"law","law":"intermittent"}"#, law(LawId::Intermittent));
    check(r#"{"kind":"law","law":"minimum-energy"}"#, law(LawId::MinimumEnergy));
    check(r#"{"kind":"law","law":"time-fuel"}"#, law(LawId::TimeFuel));
    check(r#"{"kind":"law","law":"eco"}"#, law(LawId::Eco));
    check(r#"{"kind":"helmsman"}"#, pilot(OperatorRequest::ReleaseBoat));
    let drawn =
        |kind| DrawnMark { kind, pixel: PixelPoint { u: 4.5, v: -1.0 }, captured: Timestamp::from_nanos(17) };
    for (name, kind) in [
        ("place", MarkKind::Place),
        ("person", MarkKind::Person),
        ("way-point", MarkKind::WayPoint),
        ("forbidden", MarkKind::Forbidden),
        ("home", MarkKind::Home),
    ] {
        let json = format!(r#"{{"kind":"mark","mark":"{name}","at":[4.5,-1],"captured_ns":17}}"#);
        check(&json, pilot(OperatorRequest::Mark(drawn(kind))));
    }
    let moved = MovedMark { id: 2, pixel: PixelPoint { u: 1.0, v: 2.0 }, captured: Timestamp::from_nanos(9) };
    check(
        r#"{"kind":"move-mark","id":2,"at":[1,2],"captured_ns":9}"#,
        pilot(OperatorRequest::MoveMark(moved)),
    );
    check(r#"{"kind":"unmark","id":3}"#, pilot(OperatorRequest::Unmark(3)));
    check(r#"{"kind":"unmark-all"}"#, pilot(OperatorRequest::UnmarkAll));
    check(r#"{"kind":"next-mark"}"#, pilot(OperatorRequest::NextMark));
    check(r#"{"kind":"stop-boat"}"#, pilot(OperatorRequest::StopBoat(BoatStop::Operator)));
    check(r#"{"kind":"pause"}"#, Request::World(DriveInput::Pause));
    check(r#"{"kind":"resume"}"#, Request::World(DriveInput::Resume));
}

#[test]
fn the_boat_is_commanded_from_a_page_only() {
    for (request, expected) in [
        (
            ConsoleRequest::Helm { thrust: 1.0, rudder: -0.5 },
            OperatorRequest::Steer(VesselCommand { throttle: 1.0, rudder: 0.5 }),
        ),
        (ConsoleRequest::Guide, OperatorRequest::Guide),
        (ConsoleRequest::GoHome, OperatorRequest::GoHome),
    ] {
        let mut session = InMemory::new(LIVE);
        let (answer, reason) = session.request(CONTROL, None, request);
        assert_eq!(answer, AnswerKind::Refused);
        assert!(reason.unwrap_or_default().contains("only a page on a socket"), "{request:?}");
        session.join("a", CONTROL);
        assert_eq!(session.request(CONTROL, Some(0), request).0, AnswerKind::Accepted);
        assert_eq!(session.taken, [Request::Pilot(expected)]);
    }
}

#[test]
fn values_without_sense_are_refused_with_the_reason() {
    for bounds in ["[0,0,0,5]", "[0,0,5,0]", "[0,0,-5,5]", "[0,0,5,-0.0]"] {
        check_refused(&format!(r#"{{"kind":"select","box":{bounds},"captured_ns":0}}"#), "the box must have");
    }
    for (first, second) in [("1.01", "0"), ("0", "-1.01"), ("1e300", "0"), ("-100", "100")] {
        let range = "numbers from -1 to 1";
        check_refused(&format!(r#"{{"kind":"nudge","pan":{first},"tilt":{second}}}"#), range);
        let mut session = InMemory::new(LIVE);
        session.join("a", CONTROL);
        let helm = parsed(&format!(r#"{{"kind":"helm","thrust":{first},"rudder":{second}}}"#));
        let (answer, reason) = session.request(CONTROL, Some(0), helm);
        assert_eq!((answer, session.taken.len()), (AnswerKind::Refused, 0));
        assert!(reason.unwrap_or_default().contains(range));
    }
}

#[test]
fn numbers_that_json_cannot_carry_are_refused_too() {
    let select = |bounds| ConsoleRequest::Select { bounds, captured_ns: 0 };
    let nan = f64::NAN;
    for request in [
        select([nan, 0.0, 1.0, 1.0]),
        select([0.0, f64::INFINITY, 1.0, 1.0]),
        select([0.0, 0.0, f64::INFINITY, 1.0]),
        select([0.0, 0.0, 1.0, nan]),
        ConsoleRequest::Nudge { pan: nan, tilt: 0.0 },
        ConsoleRequest::Nudge { pan: 0.0, tilt: f64::NEG_INFINITY },
        ConsoleRequest::Helm { thrust: nan, rudder: 0.0 },
        ConsoleRequest::Helm { thrust: 0.0, rudder: nan },
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
fn check_from(from: Who, request: ConsoleRequest, reason: &str) {
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
    let (answer, given) = session.request(role, client, request);
    let expected = if reason.is_empty() { AnswerKind::Accepted } else { AnswerKind::Refused };
    assert_eq!(answer, expected, "{from:?} {request:?}: {given:?}");
    assert!(given.unwrap_or_default().contains(reason), "{from:?} {request:?}");
    let is_refused = answer == AnswerKind::Refused;
    assert!(!is_refused || session.taken.is_empty(), "a refused request does not reach the session");
}

#[test]
fn a_session_is_commanded_from_the_control_seat_only() {
    for request in [
        ConsoleRequest::Engage,
        ConsoleRequest::Disengage,
        ConsoleRequest::Reject,
        ConsoleRequest::Deselect,
        ConsoleRequest::Select { bounds: [1.0, 2.0, 3.0, 4.0], captured_ns: 5 },
        ConsoleRequest::Nudge { pan: 0.0, tilt: 0.0 },
        ConsoleRequest::Law { law: LawName::Eco },
        ConsoleRequest::Helm { thrust: 0.0, rudder: 0.0 },
        ConsoleRequest::Helmsman,
        ConsoleRequest::Pause,
        ConsoleRequest::Resume,
    ] {
        check_from(Holder, request, "");
        check_from(Other, request, "another page is in control: ask for the control, or take it");
        check_from(Viewer, request, "this token may only watch and stop");
        check_from(Dropped, request, "another page is in control");
        check_from(Program, request, "a page is in control");
        check_from(ViewingProgram, request, "this token may only watch and stop");
    }
}

#[test]
fn everybody_can_stop() {
    for from in [Holder, Other, Viewer, Dropped, Program, ViewingProgram] {
        check_from(from, ConsoleRequest::Stop, "");
    }
}

#[test]
fn control_moves_between_pages_that_may_control() {
    let (take, ask) = (ConsoleRequest::TakeControl, ConsoleRequest::AskControl);
    let give = |client| ConsoleRequest::GiveControl { client };
    let may_watch = "this token may only watch";
    for request in [take, ask, give(0)] {
        check_from(Viewer, request, may_watch);
        check_from(ViewingProgram, request, may_watch);
        check_from(Program, request, "only a page on a socket can control");
    }
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
    session.request(CONTROL, Some(second), ConsoleRequest::AskControl);
    assert_eq!((seat.borrow().holder, seat.borrow().asking.clone()), (Some(first), vec![second]));
    session.request(CONTROL, Some(first), ConsoleRequest::GiveControl { client: second });
    assert_eq!((seat.borrow().holder, seat.borrow().asking.clone()), (Some(second), vec![]));
    session.request(CONTROL, Some(first), ConsoleRequest::TakeControl);
    assert_eq!(seat.borrow().holder, Some(first));
    session.request(CONTROL, Some(second), ConsoleRequest::GiveControl { client: second });
    let notices = ["page 1 asks for the control", "page 0 gave the control away", "page 0 took the control"];
    assert_eq!(session.logged("control"), notices, "a refused request is no change");
}

#[test]
fn a_program_may_command_while_no_page_is_there() {
    let mut session = InMemory::new(LIVE);
    let watcher = session.join("w", WATCH);
    assert_eq!(session.request(CONTROL, None, ConsoleRequest::Engage), ACCEPTED);
    let page = session.join("a", CONTROL);
    assert_eq!(session.request(CONTROL, None, ConsoleRequest::Engage).0, AnswerKind::Refused);
    session.console.with_seats(|seats| seats.leave(page, session.console.time.clock()));
    let reply = session.request(CONTROL, None, ConsoleRequest::Engage);
    assert_eq!(reply.0, AnswerKind::Refused, "the seat of a lost page is kept for a reload");
    assert_eq!(session.request(WATCH, Some(watcher), ConsoleRequest::Stop), ACCEPTED);
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
        assert_eq!(session.request(CONTROL, None, ConsoleRequest::Engage), expected);
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
    let from = Requester { role: CONTROL, client: None };
    let waiting = begin_request(&session.console, from, ConsoleRequest::Engage);
    let stop = begin_request(&session.console, from, ConsoleRequest::Stop);
    session.take_requests();
    assert_eq!(session.taken, [], "the pilot is not engaged after the stop");
    let superseded = (AnswerKind::Superseded, Some("stopped".to_owned()));
    assert_eq!(block_on(answer(&session.console, waiting)), superseded);
    assert_eq!(block_on(answer(&session.console, stop)), ACCEPTED);
}

#[test]
fn repeated_stops_are_all_acknowledged_by_one_step() {
    let mut session = InMemory::new(LIVE);
    let from = Requester { role: WATCH, client: None };
    let stops = [(); 3].map(|()| begin_request(&session.console, from, ConsoleRequest::Stop));
    session.take_requests();
    assert_eq!(session.publisher.newest().steps, 1);
    for stop in stops {
        assert_eq!(block_on(answer(&session.console, stop)), ACCEPTED);
    }
}

#[test]
fn a_stop_that_is_pressed_again_is_not_acknowledged_by_the_step_before() {
    let mut session = InMemory::new(LIVE);
    assert_eq!(session.request(WATCH, None, ConsoleRequest::Stop), ACCEPTED);
    let from = Requester { role: WATCH, client: None };
    let second = begin_request(&session.console, from, ConsoleRequest::Stop);
    assert!(matches!(second, Pending::Stop(2)), "{second:?}");
    let InMemory { console, publisher, .. } = session;
    drop(publisher);
    assert_eq!(block_on(answer(&console, second)).0, AnswerKind::Refused);
}
