//! The operator's requests, to and from their stored form.

use barrelman_vocab::OperatorRequest;

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
            OperatorRequest::Engage => stored::RequestKind::Engage,
            OperatorRequest::Disengage => stored::RequestKind::Disengage,
            OperatorRequest::Stop(cause) => {
                message.stop_cause = stored::StopCause::from(*cause) as i32;
                stored::RequestKind::Stop
            }
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
            stored::RequestKind::Engage => Self::Engage,
            stored::RequestKind::Disengage => Self::Disengage,
            stored::RequestKind::Stop => Self::Stop(message.stop_cause().try_into()?),
            stored::RequestKind::Unknown => return Err(missing("kind")),
        })
    }
}
