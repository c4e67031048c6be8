//! The alarms of a session.

/// What an operator has to know at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
}

impl Alarm {
    /// The alarm's name in the API.
    pub const fn key(self) -> &'static str {
        match self {
            Self::TrackLost => "track-lost",
            Self::StaleVideo => "stale-video",
            Self::NoVideo => "no-video",
            Self::LinkDown => "link-down",
            Self::CameraMayTurn => "camera-may-turn",
            Self::CameraTurns => "camera-turns",
            Self::BoatMoves => "boat-moves",
            Self::ControlLost => "control-lost",
            Self::EndStop => "end-stop",
            Self::Emergency => "emergency",
            Self::BatteryLow => "battery-low",
            Self::RecordingFailed => "recording-failed",
            Self::ConsoleLost => "console-lost",
            Self::NetYaw => "net-yaw",
            Self::NetYawLimit => "net-yaw-limit",
        }
    }

    /// The alarm in words, for the event log.
    pub const fn text(self) -> &'static str {
        match self {
            Self::TrackLost => "the track is lost: select the boat again",
            Self::StaleVideo => "the video is delayed",
            Self::NoVideo => "no video arrives",
            Self::LinkDown => "the link is down: commands do not reach the camera",
            Self::CameraMayTurn => {
                "nothing reaches the camera, which may be turning: stop it at the ground station"
            }
            Self::CameraTurns => "the camera turns although zero is commanded: stop it at the ground station",
            Self::BoatMoves => {
                "the boat moves although neutral is commanded: stop it with its remote control or at its ground station"
            }
            Self::ControlLost => "the vehicle does not accept commands from this program",
            Self::EndStop => "the camera is near its end stop",
            Self::Emergency => "the vehicle reports an emergency",
            Self::BatteryLow => "the vehicle says that a battery is low",
            Self::RecordingFailed => "the recording has stopped",
            Self::ConsoleLost => "the controlling page is gone; the camera stays engaged",
            Self::NetYaw => "the tether winds up: turn the camera back",
            Self::NetYawLimit => "the tether is wound up: the camera turns back only",
        }
    }
}
