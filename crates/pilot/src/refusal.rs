//! Why a request has no effect.

use core::fmt;
use core::time::Duration;

use barrelman_vision::NoProposal;
use barrelman_vocab::{HoldCause, Named as _};

use crate::purpose::Purpose;
use crate::vessel::no_water::{GO_AGAIN, NoWater};
use crate::vessel::said::Said;

/// Largest net yaw that an operator can state, degrees: ten turns.
pub(crate) const MAX_NET_YAW_DEG: f64 = 3_600.0;
/// A target must be lost for this time before the operator can ask for a search: the tracker's own search is
/// faster.
pub const LOST_BEFORE_SEARCH: Duration = Duration::from_secs(3);

/// The reason why a request has no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// The video frame of the selection is no longer kept.
    SelectionTooOld {
        /// Age of the video frame.
        age: Duration,
        /// How long video frames are kept.
        kept: Duration,
    },
    /// The video frame of the selection or mark is of the video that was followed before.
    OtherVideo,
    /// The video frame of the selection or mark is not taken yet.
    NotYetCaptured,
    /// A tap that proposes nothing, for this reason.
    NothingProposed(NoProposal),
    /// A turn by hand or a change of the law while the pilot is engaged.
    Engaged,
    /// A nudge while the pilot is stopped.
    Stopped,
    /// A nudge, a helm, Go or a mark without fresh video: the operator cannot see what the camera looks at.
    NoFreshVideo,
    /// A zoom of a camera that has none.
    NoZoom,
    /// A zoom of a camera that has not told whether it zooms.
    ZoomNotKnown,
    /// No object is followed that could be rejected.
    NothingToReject,
    /// The camera moves for another purpose.
    Busy(Purpose),
    /// A nudge while no command may move the camera, for this reason.
    NoMotion(HoldCause),
    /// A search while no target is lost.
    NothingLost,
    /// A search for a target that was lost just now.
    LostTooBriefly,
    /// A net yaw that is no number, or larger than any tether bears.
    NetYawOutOfRange,
    /// A request about a boat that is not connected.
    NoVessel,
    /// The boat cannot be commanded, for this reason.
    NoVesselMotion(HoldCause),
    /// The boat takes no commands, for this reason.
    NotAccepted(Said),
    /// The helm was held when the boat was stopped or took no commands, and was not let go since.
    HelmHeld,
    /// People or areas are marked, and the boat would go in the picture, which keeps out of no circles: asked
    /// once more.
    PictureOnly(NoWater),
    /// There is no candidate of that number.
    NoSuchCandidate,
    /// There is no mark of that number.
    NoSuchMark,
    /// There is no mark that could be a destination.
    NothingMarked,
    /// No place is marked as home.
    NoHome,
    /// There is no guidance: the boat is steered by hand alone.
    ByHandOnly,
    /// The boat is not followed in fresh video.
    BoatNotSeen,
    /// There are as many marks as there can be.
    TooManyMarks,
    /// A mark at the horizon, or above it.
    MarkNotOnWater,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SelectionTooOld { age, kept } => write!(
                f,
                "the picture of the selection is {:.1} s old; select within {:.1} s",
                age.as_secs_f64(),
                kept.as_secs_f64()
            ),
            Self::OtherVideo => {
                f.write_str("the picture is from before the change of the video: draw or tap once more")
            }
            Self::NotYetCaptured => f.write_str(
                "the time of the picture lies in the future: captured_ns must be that of a picture of this run",
            ),
            Self::NothingProposed(why) => why.fmt(f),
            Self::Engaged => f.write_str("the camera is engaged: disengage first"),
            Self::Stopped => f.write_str("the camera is stopped: disengage first"),
            Self::NoFreshVideo => f.write_str("there is no fresh video: nothing is moved blindly"),
            Self::NoZoom => f.write_str("this camera does not zoom"),
            Self::ZoomNotKnown => f.write_str("the camera has not told yet whether it zooms"),
            Self::NothingToReject => f.write_str("no object is followed"),
            Self::Busy(purpose) => {
                let now = match purpose {
                    Purpose::Follow => "following",
                    Purpose::Nudge => "turned by hand",
                    Purpose::Search => "searching",
                    Purpose::Calibrate => "being calibrated",
                };
                write!(f, "the camera is {now}: stop or disengage first")
            }
            Self::NoMotion(cause) => write!(f, "the camera cannot be turned now: {}", cause.text()),
            Self::NothingLost => {
                f.write_str("no boat is lost: a search is for a boat that was selected and is lost")
            }
            Self::LostTooBriefly => write!(
                f,
                "the boat was lost just now: a search can begin {} s after the loss",
                LOST_BEFORE_SEARCH.as_secs()
            ),
            Self::NetYawOutOfRange => {
                write!(
                    f,
                    "the net yaw must be a number of degrees from -{MAX_NET_YAW_DEG} to {MAX_NET_YAW_DEG}"
                )
            }
            Self::NoVessel => f.write_str("there is no boat to command: start with --vessel"),
            Self::NoVesselMotion(cause) => {
                write!(f, "the boat cannot be commanded now: {}", cause.text())
            }
            Self::NotAccepted(said) => said.fmt(f),
            Self::HelmHeld => {
                f.write_str("the boat was stopped, or took no commands: let go of the helm first")
            }
            Self::PictureOnly(why) => write!(
                f,
                "{}: press Go again within {} s to go in the picture, which keeps out of no circles",
                why.text(),
                GO_AGAIN.as_secs()
            ),
            Self::NoSuchCandidate => f.write_str("there is no candidate of that number now"),
            Self::NoSuchMark => f.write_str("there is no such mark"),
            Self::NothingMarked => f.write_str("nothing is marked: mark a place or a person first"),
            Self::NoHome => f.write_str("no home is marked: mark it first"),
            Self::ByHandOnly => f.write_str("the boat is steered by hand alone: start with --guidance los"),
            Self::BoatNotSeen => f.write_str("the boat is not seen: select it first"),
            Self::TooManyMarks => f.write_str("there are too many marks: remove one first"),
            Self::MarkNotOnWater => f.write_str("there is no water at that point: mark below the horizon"),
        }
    }
}
