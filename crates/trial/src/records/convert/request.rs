//! The operator's requests, to and from their stored form.

use barrelman_vocab::{
    Angle, DrawnMark, DrawnSelection, MovedMark, Nudge, OperatorRequest, PixelPoint, Timestamp, VesselCommand,
};

use super::malformed::{Malformed, missing};
use crate::records::stored;

impl From<&OperatorRequest> for stored::RequestInput {
    fn from(request: &OperatorRequest) -> Self {
        let mut message = Self::default();
        message.kind = match request {
            OperatorRequest::Select(selection) => {
                message.selection = Some((*selection).into());
                stored::RequestKind::Select
            }
            OperatorRequest::SelectOn(DrawnSelection { bounds, captured }) => {
                message.selection = Some((*bounds).into());
                message.drawn_on_ns = captured.as_nanos();
                stored::RequestKind::SelectOn
            }
            OperatorRequest::Reject => stored::RequestKind::Reject,
            OperatorRequest::Deselect => stored::RequestKind::Deselect,
            OperatorRequest::Nudge(nudge) => {
                (message.nudge_pan, message.nudge_tilt) = (nudge.pan, nudge.tilt);
                stored::RequestKind::Nudge
            }
            OperatorRequest::ChangeLaw(law) => {
                message.law = stored::LawId::from(*law) as i32;
                stored::RequestKind::ChangeLaw
            }
            OperatorRequest::Search => stored::RequestKind::Search,
            OperatorRequest::Calibrate => stored::RequestKind::Calibrate,
            OperatorRequest::SetNetYaw(net) => {
                message.net_yaw_rad = net.radians();
                stored::RequestKind::SetNetYaw
            }
            OperatorRequest::Engage => stored::RequestKind::Engage,
            OperatorRequest::Disengage => stored::RequestKind::Disengage,
            OperatorRequest::Stop(cause) => {
                message.stop_cause = stored::StopCause::from(*cause) as i32;
                stored::RequestKind::Stop
            }
            OperatorRequest::Mark(DrawnMark { kind, pixel, captured }) => {
                message.mark_kind = stored::MarkKind::from(*kind) as i32;
                (message.mark_u, message.mark_v) = (pixel.u, pixel.v);
                message.drawn_on_ns = captured.as_nanos();
                stored::RequestKind::Mark
            }
            OperatorRequest::MoveMark(MovedMark { id, pixel, captured }) => {
                message.mark_id = *id;
                (message.mark_u, message.mark_v) = (pixel.u, pixel.v);
                message.drawn_on_ns = captured.as_nanos();
                stored::RequestKind::MoveMark
            }
            OperatorRequest::Unmark(id) => {
                message.mark_id = *id;
                stored::RequestKind::Unmark
            }
            OperatorRequest::UnmarkAll => stored::RequestKind::UnmarkAll,
            OperatorRequest::NextMark => stored::RequestKind::NextMark,
            OperatorRequest::Guide => stored::RequestKind::Guide,
            OperatorRequest::GoHome => stored::RequestKind::GoHome,
            OperatorRequest::Steer(VesselCommand { throttle, rudder }) => {
                (message.throttle, message.rudder) = (*throttle, *rudder);
                stored::RequestKind::Steer
            }
            OperatorRequest::StopBoat(by) => {
                message.boat_stop = stored::BoatStop::from(*by) as i32;
                stored::RequestKind::StopBoat
            }
            OperatorRequest::ReleaseBoat => stored::RequestKind::ReleaseBoat,
        } as i32;
        message
    }
}

impl TryFrom<stored::RequestInput> for OperatorRequest {
    type Error = Malformed;

    fn try_from(message: stored::RequestInput) -> Result<Self, Malformed> {
        Ok(match message.kind() {
            stored::RequestKind::Select => {
                Self::Select(message.selection.ok_or_else(|| missing("selection"))?.into())
            }
            stored::RequestKind::SelectOn => Self::SelectOn(DrawnSelection {
                bounds: message.selection.ok_or_else(|| missing("selection"))?.into(),
                captured: Timestamp::from_nanos(message.drawn_on_ns),
            }),
            stored::RequestKind::Reject => Self::Reject,
            stored::RequestKind::Deselect => Self::Deselect,
            stored::RequestKind::Nudge => {
                Self::Nudge(Nudge { pan: message.nudge_pan, tilt: message.nudge_tilt })
            }
            stored::RequestKind::ChangeLaw => Self::ChangeLaw(message.law().try_into()?),
            stored::RequestKind::Search => Self::Search,
            stored::RequestKind::Calibrate => Self::Calibrate,
            stored::RequestKind::SetNetYaw => Self::SetNetYaw(Angle::from_radians(message.net_yaw_rad)),
            stored::RequestKind::Engage => Self::Engage,
            stored::RequestKind::Disengage => Self::Disengage,
            stored::RequestKind::Stop => Self::Stop(message.stop_cause().try_into()?),
            stored::RequestKind::Mark => Self::Mark(DrawnMark {
                kind: message.mark_kind().try_into()?,
                pixel: PixelPoint { u: message.mark_u, v: message.mark_v },
                captured: Timestamp::from_nanos(message.drawn_on_ns),
            }),
            stored::RequestKind::MoveMark => Self::MoveMark(MovedMark {
                id: message.mark_id,
                pixel: PixelPoint { u: message.mark_u, v: message.mark_v },
                captured: Timestamp::from_nanos(message.drawn_on_ns),
            }),
            stored::RequestKind::Unmark => Self::Unmark(message.mark_id),
            stored::RequestKind::UnmarkAll => Self::UnmarkAll,
            stored::RequestKind::NextMark => Self::NextMark,
            stored::RequestKind::Guide => Self::Guide,
            stored::RequestKind::GoHome => Self::GoHome,
            stored::RequestKind::Steer => {
                Self::Steer(VesselCommand { throttle: message.throttle, rudder: message.rudder })
            }
            stored::RequestKind::StopBoat => Self::StopBoat(message.boat_stop().try_into()?),
            stored::RequestKind::ReleaseBoat => Self::ReleaseBoat,
            stored::RequestKind::Unknown => return Err(missing("kind")),
        })
    }
}
