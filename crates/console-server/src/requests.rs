//! From a request of a page or a program to an answer: who may request it, whether its values make sense, and
//! what the loop makes of it.

use std::time::Duration;

use barrelman_vocab::{
    CameraRequest, DrawnMark, DrawnSelection, MovedMark, Nudge, OperatorRequest, PixelBox, PixelPoint,
    Request, SeatRequest, StopCause, Tap, VesselCommand, VesselRequest, VesselStopper,
};
use tokio::sync::oneshot;

use super::access::Role;
use super::api::AnswerKind;
use super::seats::{ClientId, Seats};
use super::shared::Console;
use crate::operator::{Answer, SessionRequest};
use crate::snapshot::Level;

/// How long a stop may take until the pilot has taken it. Beyond that the loop hangs, and the page raises an
/// alarm.
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
    /// How many stops the requester knew of; `None`: it does not say.
    pub(super) stops_taken: Option<u64>,
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
pub(super) fn begin_request(console: &Console, from: Requester, request: Request) -> Pending {
    if let Request::Operator(OperatorRequest::Stop(cause)) = request {
        return match cause {
            StopCause::Operator => Pending::Stop(console.gateway.stop()),
            _ => Pending::Answered(refused("a page or a program stops with the cause `operator` alone")),
        };
    }
    if from.client.is_none() {
        console.hear_program(from.role);
    }
    if let Some(reason) = console.with_seats(|seats| refusal(seats, from, &request)) {
        return Pending::Answered(refused(reason));
    }
    let request = match request {
        Request::Seat(request) => {
            let result = change_seats(console, from.client, request);
            return Pending::Answered(result.map_or_else(refused, |()| ACCEPTED));
        }
        Request::World(request) => SessionRequest::World(request),
        Request::Video(request) => SessionRequest::Video(request),
        Request::Note(request) => SessionRequest::Note(request),
        Request::Operator(request) => {
            if let Err(reason) = check_values(&request) {
                return Pending::Answered(refused(reason));
            }
            // Not those of the snapshot: a stop is taken before it is published.
            let pressed = console.gateway.stop_latch().pressed();
            if begins_motion(&request) && from.stops_taken.is_some_and(|known| known < pressed) {
                return Pending::Answered(refused("a stop came in the meantime: ask again"));
            }
            if commands_vessel(&request) {
                console.watch_vessel();
            }
            SessionRequest::Pilot(request)
        }
    };
    Pending::Submitted(console.gateway.submit(request))
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
fn refusal(seats: &Seats, from: Requester, request: &Request) -> Option<String> {
    if from.role == Role::Watch {
        return Some("this token may only watch and stop".to_owned());
    }
    let commands_vessel = match request {
        Request::Operator(request) => commands_vessel(request),
        Request::World(_) | Request::Video(_) => false,
        // A note commands nothing.
        Request::Seat(_) | Request::Note(_) => return None,
    };
    match from.client {
        // A boat that no page watches over is stopped at once.
        None if (seats.is_empty() || seats.program_controls()) && commands_vessel => {
            Some("only a page on a socket can command the boat".to_owned())
        }
        None if seats.is_empty() || seats.program_controls() => None,
        None => Some("a page is in control: ask for the control, or take it".to_owned()),
        Some(id) if seats.controls(id) => None,
        Some(_) if seats.program_controls() => {
            Some("a program is in control: ask for the control, or take it".to_owned())
        }
        Some(_) => Some("another page is in control: ask for the control, or take it".to_owned()),
    }
}

/// Whether a request lets the boat move.
const fn commands_vessel(request: &OperatorRequest) -> bool {
    matches!(
        request,
        OperatorRequest::Vessel(VesselRequest::Guide | VesselRequest::GoHome | VesselRequest::Steer(_))
    )
}

/// Whether camera or boat move on from a request without its renewal.
const fn begins_motion(request: &OperatorRequest) -> bool {
    matches!(
        request,
        OperatorRequest::Camera(CameraRequest::Engage | CameraRequest::Search)
            | OperatorRequest::Vessel(VesselRequest::Guide | VesselRequest::GoHome)
    )
}

/// Changes who controls. `page`: who asks for it; `None`: a program without a socket.
fn change_seats(console: &Console, page: Option<ClientId>, request: SeatRequest) -> Result<(), &'static str> {
    let now = console.time.clock();
    let joined = |seats: &mut Seats| page.unwrap_or_else(|| seats.join_program(now));
    let known = |seats: &Seats| page.or_else(|| seats.program()).ok_or("a program is not in control");
    let change = |seats: &mut Seats| match request {
        SeatRequest::TakeControl => {
            let id = joined(seats);
            seats.take(id).map(|()| "took the control")
        }
        SeatRequest::AskControl => {
            let id = joined(seats);
            seats.ask(id).map(|()| "asks for the control")
        }
        SeatRequest::GiveControl { client } => {
            let id = known(seats)?;
            seats.give(id, client).map(|()| "gave the control away")
        }
        SeatRequest::ReleaseControl => {
            let id = known(seats)?;
            seats.release(id).map(|()| "gave the control up")
        }
    };
    let text = console.with_seats(change)?;
    let who = page.map_or_else(|| "a program".to_owned(), |id| format!("page {id}"));
    console.events.add(console.time.now(), Level::Info, "control", format!("{who} {text}"));
    console.publish_seats();
    Ok(())
}

/// Whether the values of a request make sense, and are for a page or a program to give.
///
/// # Errors
/// The reason.
fn check_values(request: &OperatorRequest) -> Result<(), &'static str> {
    match request {
        OperatorRequest::Stop(_) => Ok(()),
        OperatorRequest::Camera(request) => match *request {
            CameraRequest::Select(DrawnSelection { bounds, .. }) | CameraRequest::SelectNext(bounds) => {
                check_box(bounds)
            }
            CameraRequest::Propose(Tap { at, .. }) => check_point(at),
            CameraRequest::Nudge(Nudge { pan, tilt, zoom }) => check_shares([pan, tilt, zoom]),
            CameraRequest::NetYaw { degrees } if !degrees.is_finite() => {
                Err("the net yaw must be a number of degrees")
            }
            CameraRequest::Calibrate { .. } => {
                Err("calibrate with `barrelman calibrate axes`, which stores the result")
            }
            CameraRequest::NetYaw { .. }
            | CameraRequest::KeepSize { .. }
            | CameraRequest::Candidates { .. }
            | CameraRequest::TakeCandidate { .. }
            | CameraRequest::Reject
            | CameraRequest::Deselect
            | CameraRequest::Search
            | CameraRequest::Law { .. }
            | CameraRequest::Engage
            | CameraRequest::Disengage => Ok(()),
        },
        OperatorRequest::Vessel(request) => match *request {
            VesselRequest::Mark(DrawnMark { at, .. }) | VesselRequest::MoveMark(MovedMark { at, .. }) => {
                check_point(at)
            }
            VesselRequest::Steer(VesselCommand { throttle, rudder }) => check_shares([throttle, rudder]),
            VesselRequest::StopVessel { by: VesselStopper::ConsoleLost } => {
                Err("a page or a program stops the boat by `operator` alone")
            }
            VesselRequest::StopVessel { by: VesselStopper::Operator }
            | VesselRequest::Unmark { .. }
            | VesselRequest::UnmarkAll
            | VesselRequest::NextMark
            | VesselRequest::Guide
            | VesselRequest::GoHome
            | VesselRequest::ReleaseVessel => Ok(()),
        },
    }
}

fn check_box(PixelBox { u, v, w, h }: PixelBox) -> Result<(), &'static str> {
    if [u, v, w, h].iter().all(|value| value.is_finite()) && w > 0.0 && h > 0.0 {
        Ok(())
    } else {
        Err("the box must have four numbers, and a width and a height above zero")
    }
}

fn check_point(PixelPoint { u, v }: PixelPoint) -> Result<(), &'static str> {
    if u.is_finite() && v.is_finite() { Ok(()) } else { Err("the point must have two numbers") }
}

fn check_shares<const N: usize>(shares: [f64; N]) -> Result<(), &'static str> {
    if shares.iter().all(|share| (-1.0..=1.0).contains(share)) {
        Ok(())
    } else {
        Err("the values must be numbers from -1 to 1")
    }
}

#[cfg(test)]
mod tests;
