//! From a request of a page or a program to an answer: who may request it, whether its values make sense, and what the
//! loop makes of it.

use std::time::Duration;

use barrelman_experiments::drive::DriveInput;
use barrelman_vocab::{
    Angle, BoatStop, DrawnMark, DrawnSelection, LawId, MarkKind, MovedMark, Nudge, OperatorRequest, PixelBox,
    PixelPoint, Timestamp, VesselCommand,
};

use tokio::sync::oneshot;

use super::access::Role;
use super::api::{AnswerKind, ConsoleRequest, LawName, MarkName};
use super::seats::{ClientId, Seats};
use super::shared::Console;
use crate::operator::{Answer, Request};
use crate::snapshot::Level;

/// How long a stop may take until the pilot has taken it. Beyond that the loop hangs, and the page raises an alarm.
const STOP_TIMEOUT: Duration = Duration::from_secs(2);
/// How long the answer to a request may take. A selection is confirmed or given up much earlier.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);

/// Who makes a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Requester {
    /// What the requester's token permits.
    pub(super) role: Role,
    /// The page; `None`: a program without a socket.
    pub(super) client: Option<ClientId>,
}

pub(super) type Reply = (AnswerKind, Option<String>);

fn refused(reason: impl Into<String>) -> Reply {
    (AnswerKind::Refused, Some(reason.into()))
}

const ACCEPTED: Reply = (AnswerKind::Accepted, None);

/// A request that was made, and whose answer may still be to come.
#[derive(Debug)]
pub(super) enum Pending {
    /// Answered at once.
    Answered(Reply),
    /// A press of Stop, until the pilot has taken it.
    Stop(u64),
    /// The gateway answers.
    Submitted(oneshot::Receiver<Answer>),
}

/// Makes a request. Does not wait, so that the requests of a page are made in their order.
pub(super) fn begin_request(console: &Console, from: Requester, request: ConsoleRequest) -> Pending {
    if request == ConsoleRequest::Stop {
        return Pending::Stop(console.gateway.stop());
    }
    if let Some(reason) = console.with_seats(|seats| refusal(seats, from, &request)) {
        return Pending::Answered(refused(reason));
    }
    if let Some(result) = change_seats(console, from, &request) {
        return Pending::Answered(result.map_or_else(refused, |()| ACCEPTED));
    }
    if commands_boat(&request) {
        console.gateway.set_boat_left(false);
    }
    match session_request(&request) {
        Ok(request) => Pending::Submitted(console.gateway.submit(request)),
        Err(reason) => Pending::Answered(refused(reason)),
    }
}

/// Waits for the answer to a request.
pub(super) async fn answer(console: &Console, pending: Pending) -> Reply {
    match pending {
        Pending::Answered(reply) => reply,
        Pending::Stop(press) => {
            let mut snapshots = console.snapshots.clone();
            let taken = snapshots.wait_for(|snapshot| snapshot.stops_taken >= press);
            match tokio::time::timeout(STOP_TIMEOUT, taken).await {
                Ok(Ok(_)) => ACCEPTED,
                _ => refused("the stop was not acknowledged in time: use the ground station's own stop"),
            }
        }
        Pending::Submitted(answer) => match tokio::time::timeout(ANSWER_TIMEOUT, answer).await {
            Ok(Ok(Answer::Accepted(remark))) => (AnswerKind::Accepted, remark),
            Ok(Ok(Answer::Refused(reason))) => refused(reason),
            Ok(Ok(Answer::Superseded(reason))) => (AnswerKind::Superseded, Some(reason)),
            Ok(Err(_)) => refused("the session has ended"),
            Err(_) => refused("no answer in time"),
        },
    }
}

/// Why this requester may not make this request; `None`: the requester may.
fn refusal(seats: &Seats, from: Requester, request: &ConsoleRequest) -> Option<String> {
    if from.role == Role::Watch {
        return Some("this token may only watch and stop".to_owned());
    }
    let is_about_seats = matches!(
        request,
        ConsoleRequest::TakeControl | ConsoleRequest::AskControl | ConsoleRequest::GiveControl { .. }
    );
    match from.client {
        None if is_about_seats => Some("only a page on a socket can control".to_owned()),
        // A boat that no page watches over is stopped at once.
        None if seats.is_empty() && commands_boat(request) => {
            Some("only a page on a socket can command the boat".to_owned())
        }
        None if seats.is_empty() => None,
        None => Some("a page is in control".to_owned()),
        Some(_) if is_about_seats => None,
        Some(id) if seats.controls(id) => None,
        Some(_) => Some("another page is in control: ask for the control, or take it".to_owned()),
    }
}

/// Whether a request lets the boat move.
const fn commands_boat(request: &ConsoleRequest) -> bool {
    matches!(request, ConsoleRequest::Guide | ConsoleRequest::GoHome | ConsoleRequest::Helm { .. })
}

/// Changes who controls. `None`: the request is about something else.
fn change_seats(
    console: &Console,
    from: Requester,
    request: &ConsoleRequest,
) -> Option<Result<(), &'static str>> {
    let id = from.client?;
    let (result, text) = match *request {
        ConsoleRequest::TakeControl => (console.with_seats(|seats| seats.take(id)), "took the control"),
        ConsoleRequest::AskControl => (console.with_seats(|seats| seats.ask(id)), "asks for the control"),
        ConsoleRequest::GiveControl { client } => {
            (console.with_seats(|seats| seats.give(id, client)), "gave the control away")
        }
        _ => return None,
    };
    if result.is_ok() {
        console.events.add(console.time.now(), Level::Info, "control", format!("page {id} {text}"));
        console.publish_seats();
    }
    Some(result)
}

/// The session's form of a request that is neither a stop nor about control.
fn session_request(request: &ConsoleRequest) -> Result<Request, &'static str> {
    let pilot = |request| Ok(Request::Pilot(request));
    match *request {
        ConsoleRequest::Select { bounds: [u, v, w, h], captured_ns } => {
            if ![u, v, w, h].iter().all(|value| value.is_finite()) || w <= 0.0 || h <= 0.0 {
                return Err("the box must have four numbers, and a width and a height above zero");
            }
            let captured = Timestamp::from_nanos(captured_ns);
            pilot(OperatorRequest::SelectOn(DrawnSelection { bounds: PixelBox { u, v, w, h }, captured }))
        }
        ConsoleRequest::Reject => pilot(OperatorRequest::Reject),
        ConsoleRequest::Deselect => pilot(OperatorRequest::Deselect),
        ConsoleRequest::Engage => pilot(OperatorRequest::Engage),
        ConsoleRequest::Disengage => pilot(OperatorRequest::Disengage),
        ConsoleRequest::Nudge { pan, tilt } => {
            in_share(pan)?;
            in_share(tilt)?;
            pilot(OperatorRequest::Nudge(Nudge { pan, tilt }))
        }
        ConsoleRequest::Search => pilot(OperatorRequest::Search),
        ConsoleRequest::NetYaw { degrees } if degrees.is_finite() => {
            pilot(OperatorRequest::SetNetYaw(Angle::from_degrees(degrees)))
        }
        ConsoleRequest::NetYaw { .. } => Err("the net yaw must be a number of degrees"),
        ConsoleRequest::Law { law } => pilot(OperatorRequest::ChangeLaw(match law {
            LawName::Schema => LawId::MotorSchema,
            LawName::MinimumEnergy => LawId::MinimumEnergy,
            LawName::TimeFuel => LawId::TimeFuel,
            LawName::Eco => LawId::Eco,
            LawName::Intermittent => LawId::Intermittent,
        })),
        ConsoleRequest::Helm { thrust, rudder } => {
            in_share(thrust)?;
            in_share(rudder)?;
            pilot(OperatorRequest::Steer(VesselCommand { throttle: thrust, rudder: -rudder }))
        }
        ConsoleRequest::Helmsman => pilot(OperatorRequest::ReleaseBoat),
        ConsoleRequest::Mark { mark, at: [u, v], captured_ns } => {
            if !(u.is_finite() && v.is_finite()) {
                return Err("the point must have two numbers");
            }
            pilot(OperatorRequest::Mark(DrawnMark {
                kind: match mark {
                    MarkName::Place => MarkKind::Place,
                    MarkName::Person => MarkKind::Person,
                    MarkName::WayPoint => MarkKind::WayPoint,
                    MarkName::Forbidden => MarkKind::Forbidden,
                    MarkName::Home => MarkKind::Home,
                },
                pixel: PixelPoint { u, v },
                captured: Timestamp::from_nanos(captured_ns),
            }))
        }
        ConsoleRequest::MoveMark { id, at: [u, v], captured_ns } => {
            if !(u.is_finite() && v.is_finite()) {
                return Err("the point must have two numbers");
            }
            let captured = Timestamp::from_nanos(captured_ns);
            pilot(OperatorRequest::MoveMark(MovedMark { id, pixel: PixelPoint { u, v }, captured }))
        }
        ConsoleRequest::Unmark { id } => pilot(OperatorRequest::Unmark(id)),
        ConsoleRequest::UnmarkAll => pilot(OperatorRequest::UnmarkAll),
        ConsoleRequest::NextMark => pilot(OperatorRequest::NextMark),
        ConsoleRequest::Guide => pilot(OperatorRequest::Guide),
        ConsoleRequest::GoHome => pilot(OperatorRequest::GoHome),
        ConsoleRequest::StopBoat => pilot(OperatorRequest::StopBoat(BoatStop::Operator)),
        ConsoleRequest::Pause => Ok(Request::World(DriveInput::Pause)),
        ConsoleRequest::Resume => Ok(Request::World(DriveInput::Resume)),
        ConsoleRequest::Stop
        | ConsoleRequest::TakeControl
        | ConsoleRequest::AskControl
        | ConsoleRequest::GiveControl { .. } => Err("the request is not for the session"),
    }
}

fn in_share(share: f64) -> Result<(), &'static str> {
    if (-1.0..=1.0).contains(&share) { Ok(()) } else { Err("the values must be numbers from -1 to 1") }
}

#[cfg(test)]
mod tests;
