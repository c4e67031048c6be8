//! The bodies of answers, as far as they are used. Fields that are not known are ignored: a later version may
//! have more.

use serde::Deserialize;

/// The camera's limits: degrees per second, and degrees relative to the kite, positive downwards.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct CameraInfo {
    /// Least pan speed other than zero.
    pub pan_speed_min: f64,
    /// Largest pan speed.
    pub pan_speed_max: f64,
    /// Least tilt speed other than zero.
    pub tilt_speed_min: f64,
    /// Largest tilt speed.
    pub tilt_speed_max: f64,
}

/// Where the camera points, degrees. What could not be measured is absent.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct CameraState {
    /// `Online` or `Offline`.
    pub online_state: Option<String>,
    /// Clockwise from north.
    pub pan_ned: Option<f64>,
    /// Downwards: 90 straight down.
    pub tilt_ned: Option<f64>,
}

/// A video stream.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct VideoStream {
    /// `zoom`, `overview` or `thermal`.
    pub stream_id: String,
    /// `Color` or `Thermal`.
    #[serde(rename = "type")]
    pub kind: Option<String>,
    /// Smallest level of the zoom.
    pub zoom_min: Option<f64>,
    /// Largest level of the zoom.
    pub zoom_max: Option<f64>,
    /// The address of the stream without encryption.
    pub rtsp_url: Option<String>,
    /// The address of the stream with encryption.
    pub rtsps_url: Option<String>,
}

/// The state of a video stream.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct VideoStreamState {
    /// Horizontal field of view, degrees.
    pub fov_horizontal: Option<f64>,
    /// Level of the zoom.
    pub zoom_level: Option<f64>,
}

/// The state of the flight.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct FlightState {
    /// `StandBy`, `Flying`, and others.
    pub flight_state: String,
}

/// The batteries, per cent.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct SystemState {
    /// The kite's.
    pub kite_battery_level: Option<f64>,
    /// The ground station's.
    pub gs_battery_level: Option<f64>,
}

/// An active notification.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Notification {
    /// `Info`, `Warning`, `Critical` or `Fatal`.
    pub severity: String,
    /// What it is about.
    #[serde(default)]
    pub code: String,
    /// When it ended; absent: it is active.
    pub end_time: Option<serde_json::Value>,
}

/// Who controls the vehicle.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct HandoffState {
    /// The client that controls; absent: there is none.
    pub controlling_client: Option<ControllingClient>,
}

/// The client that controls.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ControllingClient {
    /// How the client named itself.
    pub operator_name: Option<String>,
}

/// Reads a body; `None`: it is not what was expected.
pub fn read<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Option<T> {
    serde_json::from_slice(body).ok()
}

/// The stream that the camera's rates move and the operator zooms: `zoom`, or else the first in colour, or
/// else the first.
///
/// `chosen`: the name of the stream that is used instead; `None` where there is none of this name.
pub fn main_stream<'a>(streams: &'a [VideoStream], chosen: Option<&str>) -> Option<&'a VideoStream> {
    if let Some(chosen) = chosen {
        return streams.iter().find(|stream| stream.stream_id == chosen);
    }
    let named = streams.iter().find(|stream| stream.stream_id == "zoom");
    let coloured = || streams.iter().find(|stream| stream.kind.as_deref() == Some("Color"));
    named.or_else(coloured).or_else(|| streams.first())
}
