//! The alarms of a session.

use barrelman_vocab::Named;
use strum::{IntoStaticStr, VariantArray};

/// What an operator has to know at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Alarm {
    /// The track is lost.
    TrackLost,
    /// The video frames are too old.
    StaleVideo,
    /// No video arrives.
    NoVideo,
    /// Commands do not reach the vehicle.
    LinkDown,
    /// Nothing reaches a camera that was turning.
    CameraMayTurn,
    /// Commands do not reach the boat.
    BoatLinkDown,
    /// Nothing reaches a boat that was under way.
    BoatMayMove,
    /// The camera turns although zero is commanded.
    CameraTurns,
    /// The boat moves although neutral is commanded.
    BoatMoves,
    /// The vehicle does not accept commands from this program.
    ControlLost,
    /// The camera is near a mechanical end stop.
    EndStop,
    /// The vehicle reports an emergency.
    Emergency,
    /// A battery of the vehicle is low.
    BatteryLow,
    /// The recording has stopped.
    RecordingFailed,
    /// The controlling page is gone while the pilot is engaged.
    ConsoleLost,
    /// The tether winds up.
    NetYaw,
    /// The tether is wound up: the camera turns back only.
    NetYawLimit,
    /// The alarm of a drill.
    Drill,
}

impl Named for Alarm {
    fn text(self) -> &'static str {
        match self {
            Self::TrackLost => "boat lost",
            Self::StaleVideo => "video delayed",
            Self::NoVideo => "no video",
            Self::LinkDown => "link down: commands do not reach the camera",
            Self::CameraMayTurn => {
                "nothing reaches the camera, which may be turning: stop it at the ground station"
            }
            Self::BoatLinkDown => "link to the boat down: neither commands nor Stop reach the boat",
            Self::BoatMayMove => {
                "nothing reaches the boat, which may be under way: stop it with its remote control"
            }
            Self::CameraTurns => "camera turns although zero is commanded: stop it at the ground station",
            Self::BoatMoves => {
                "boat moves although neutral is commanded: stop it with its remote control or at its ground station"
            }
            Self::ControlLost => "vehicle does not accept commands",
            Self::EndStop => "camera near its end stop",
            Self::Emergency => "vehicle emergency",
            Self::BatteryLow => "battery of the vehicle low",
            Self::RecordingFailed => "recording failed",
            Self::ConsoleLost => "controlling page gone; the camera stays engaged",
            Self::NetYaw => "tether winds up: turn the camera back",
            Self::Drill => "drill: the camera has to be stopped at once",
            Self::NetYawLimit => "tether wound up: the camera turns back only",
        }
    }
}
