//! The moments of a sortie that somebody looks for afterwards.

use barrelman_vocab::{Named, NoteText, OperatorRequest, StopCause, VesselRequest};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something that happened, and when.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Moment {
    /// Time since the first outcome, s.
    pub at_s: f64,
    /// What happened.
    #[serde(flatten)]
    pub what: Happening,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "what", rename_all = "kebab-case")]
pub enum Happening {
    /// The operator selected a target.
    Selected,
    /// The camera began to follow the target.
    Engaged,
    /// The operator ended that.
    Disengaged,
    /// Something stopped the camera.
    Stopped {
        /// What.
        cause: StopCause,
    },
    /// The track was lost.
    Lost,
    /// The track was found again.
    Found,
    /// The operator marked a place or a person.
    Marked,
    /// The operator let the boat go to a mark.
    Guided,
    /// Somebody marked the moment.
    Noted {
        /// The text, which may be empty.
        text: NoteText,
    },
}

impl Happening {
    /// What happened by a request that the pilot received; `None`: its outcome tells.
    pub(super) fn of_request(request: &OperatorRequest) -> Option<Self> {
        match request {
            OperatorRequest::Stop(_) => None,
            OperatorRequest::Camera(request) => request.is_selection().then_some(Self::Selected),
            OperatorRequest::Vessel(request) => match request {
                VesselRequest::Mark(_) => Some(Self::Marked),
                VesselRequest::Guide | VesselRequest::GoHome => Some(Self::Guided),
                VesselRequest::MoveMark(_)
                | VesselRequest::Unmark { .. }
                | VesselRequest::UnmarkAll
                | VesselRequest::NextMark
                | VesselRequest::Steer(_)
                | VesselRequest::StopVessel { .. }
                | VesselRequest::ReleaseVessel => None,
            },
        }
    }

    /// The words.
    pub fn text(&self) -> String {
        match self {
            Self::Selected => "selected".to_owned(),
            Self::Engaged => "engaged".to_owned(),
            Self::Disengaged => "disengaged".to_owned(),
            Self::Stopped { cause } => format!("stopped: {}", cause.text()),
            Self::Lost => "boat lost".to_owned(),
            Self::Found => "boat found".to_owned(),
            Self::Marked => "marked".to_owned(),
            Self::Guided => "boat sent to a mark".to_owned(),
            Self::Noted { text } if text.as_str().is_empty() => "moment marked".to_owned(),
            Self::Noted { text } => format!("moment marked: {}", text.as_str()),
        }
    }
}
