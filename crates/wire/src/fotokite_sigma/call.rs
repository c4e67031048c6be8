//! What can be asked of a Sigma. A call that is not listed here cannot be sent: there is no take-off, no
//! landing, no altitude, no override of another client's control.

use core::time::Duration;

use serde_json::json;

use super::speeds::Speeds;
use crate::http::motion::Speeds as _;
use crate::http::{HttpCall, Lane, Method};

/// How long a command to turn lasts at most: its end is the vehicle's own dead-man's switch.
pub const TURN_DURATION: Duration = Duration::from_millis(450);
/// The duration of a command that ends the motion: the shortest that the API takes.
pub const STOP_DURATION: Duration = Duration::from_millis(100);
/// How the program is named on the vehicle's tablet.
pub const OPERATOR_NAME: &str = "Barrelman";
/// Longest text on the vehicle's tablet, characters.
pub const MAX_STATUS_CHARACTERS: usize = 160;

/// A call of the API.
#[derive(Debug, Clone, PartialEq)]
pub enum Call {
    /// The camera's limits.
    CameraInfo,
    /// Where the camera points.
    CameraState,
    /// The live state of the camera, as messages of a WebSocket.
    Subscribe,
    /// The list of the video streams.
    VideoStreams,
    /// The state of a video stream.
    VideoStreamState {
        /// The stream's name. It consists of letters, digits, `-` and `_`.
        stream: StreamId,
    },
    /// The state of the flight.
    FlightState,
    /// The batteries.
    SystemState,
    /// Active notifications.
    Notifications,
    /// Asks for the control, or keeps it.
    RequestControl,
    /// Gives the control up, or withdraws the wish for it.
    ReleaseControl,
    /// Turns the camera for a time, or stops it.
    Turn {
        /// The speeds.
        speeds: Speeds,
        /// From [`STOP_DURATION`] to [`TURN_DURATION`]; milliseconds are sent.
        duration: Duration,
    },
    /// Moves the zoom to a level, and ends there.
    Zoom {
        /// The stream.
        stream: StreamId,
        /// The level, above 0; thousandths are sent.
        level: f64,
    },
    /// Shows this program's state on the vehicle's tablet.
    ShowStatus {
        /// The state.
        status: SelfStatus,
        /// What is shown beside the state, at most [`MAX_STATUS_CHARACTERS`].
        text: &'static str,
    },
}

/// The name of a video stream that may stand in a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamId(String);

impl StreamId {
    /// The name of a stream; `None`: it contains what could lead to another path.
    pub fn new(name: &str) -> Option<Self> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        let is_usable = !name.is_empty() && name.len() <= 64 && name.chars().all(is_plain);
        is_usable.then(|| Self(name.to_owned()))
    }
}

/// This program's state on the vehicle's tablet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SelfStatus {
    /// The program has ended.
    None,
    /// All is well.
    Connected,
    /// The camera does not follow.
    Warning,
}

impl Call {
    /// A command that ends the motion.
    pub const STOP: Self = Self::Turn { speeds: Speeds::REST, duration: STOP_DURATION };
}

impl HttpCall for Call {
    const LANES: &'static [Lane] =
        &[Lane::Stop, Lane::Turn, Lane::Control, Lane::Camera, Lane::State, Lane::Socket];
    const CONTENT_TYPE: &'static str = "application/json";

    /// Commands have the shortest time: what is late has expired.
    fn timeout(lane: Lane) -> Duration {
        match lane {
            Lane::Stop | Lane::Turn => Duration::from_millis(250),
            Lane::Control | Lane::Camera => Duration::from_secs(1),
            Lane::State | Lane::Socket => Duration::from_secs(2),
        }
    }

    fn method(&self) -> Method {
        match self {
            Self::CameraInfo
            | Self::CameraState
            | Self::Subscribe
            | Self::VideoStreams
            | Self::VideoStreamState { .. }
            | Self::FlightState
            | Self::SystemState
            | Self::Notifications => Method::Get,
            Self::RequestControl
            | Self::ReleaseControl
            | Self::Turn { .. }
            | Self::Zoom { .. }
            | Self::ShowStatus { .. } => Method::Post,
        }
    }

    fn path(&self) -> String {
        match self {
            Self::CameraInfo => "/v1/camera/info",
            Self::CameraState => "/v1/camera/state",
            Self::Subscribe => "/v1/camera/state/subscribe",
            Self::VideoStreams => "/v1/videostreams",
            Self::VideoStreamState { stream } => return format!("/v1/videostreams/{}/state", stream.0),
            Self::Zoom { stream, .. } => return format!("/v1/videostreams/{}/control/zoom", stream.0),
            Self::FlightState => "/v1/flight/state",
            Self::SystemState => "/v1/system/state",
            Self::Notifications => "/v1/notifications/state",
            Self::RequestControl => "/v1/handoff/control/request",
            Self::ReleaseControl => "/v1/handoff/control/release",
            Self::Turn { .. } => "/v1/camera/control/rotate_with_speed",
            Self::ShowStatus { .. } => "/v1/auth/plugin/update",
        }
        .to_owned()
    }

    fn body(&self) -> Option<String> {
        let body = match self {
            Self::RequestControl => json!({ "operator_name": OPERATOR_NAME }),
            Self::ReleaseControl => json!({}),
            Self::Turn { speeds, duration } => json!({
                "pan_speed": speeds.pan_deg_per_s(),
                "tilt_speed": speeds.tilt_deg_per_s(),
                "duration": duration.as_millis() as f64 / 1e3,
            }),
            Self::Zoom { level, .. } => json!({ "zoom_level": (level * 1e3).round() / 1e3 }),
            Self::ShowStatus { status, text } => {
                let status = match status {
                    SelfStatus::None => "None",
                    SelfStatus::Connected => "Connected",
                    SelfStatus::Warning => "Warning",
                };
                json!({ "self_status": status, "self_status_text": text })
            }
            _ => return None,
        };
        Some(body.to_string())
    }
}
