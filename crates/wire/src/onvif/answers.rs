//! The bodies of answers, as far as they are used.

use serde::Deserialize;

/// The camera's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct DateAndTime {
    /// In UTC. A camera may tell only its local time, which is of no use.
    #[serde(rename = "UTCDateTime")]
    pub utc: Option<Moment>,
}

/// A date and a time of day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct Moment {
    /// The time of day.
    #[serde(rename = "Time")]
    pub time: TimeOfDay,
    /// The date.
    #[serde(rename = "Date")]
    pub date: Date,
}

/// A time of day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub struct TimeOfDay {
    /// 0 to 23.
    pub hour: i8,
    /// 0 to 59.
    pub minute: i8,
    /// 0 to 61.
    pub second: i8,
}

/// A date.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub struct Date {
    /// The year.
    pub year: i16,
    /// 1 to 12.
    pub month: i8,
    /// 1 to 31.
    pub day: i8,
}

/// The body with the camera's time.
#[derive(Debug, Deserialize)]
pub struct DateAndTimeBody {
    /// The answer.
    #[serde(rename = "GetSystemDateAndTimeResponse")]
    pub answer: DateAndTimeAnswer,
}

/// The answer with the camera's time.
#[derive(Debug, Deserialize)]
pub struct DateAndTimeAnswer {
    /// The time.
    #[serde(rename = "SystemDateAndTime")]
    pub told: DateAndTime,
}

/// The body with the services.
#[derive(Debug, Deserialize)]
pub struct ServicesBody {
    /// The answer.
    #[serde(rename = "GetServicesResponse")]
    pub answer: ServicesAnswer,
}

/// The services.
#[derive(Debug, Deserialize)]
pub struct ServicesAnswer {
    /// Each with its namespace and its address.
    #[serde(rename = "Service", default)]
    pub services: Vec<ServiceAddress>,
}

/// Where a service is.
#[derive(Debug, Deserialize)]
pub struct ServiceAddress {
    /// Its namespace.
    #[serde(rename = "Namespace")]
    pub namespace: String,
    /// Its address.
    #[serde(rename = "XAddr")]
    pub address: String,
}

/// The body with the capabilities.
#[derive(Debug, Deserialize)]
pub struct CapabilitiesBody {
    /// The answer.
    #[serde(rename = "GetCapabilitiesResponse")]
    pub answer: CapabilitiesAnswer,
}

/// The answer with the capabilities.
#[derive(Debug, Deserialize)]
pub struct CapabilitiesAnswer {
    /// The capabilities.
    #[serde(rename = "Capabilities")]
    pub capabilities: Capabilities,
}

/// Where the services are, in the form that came before [`ServicesAnswer`].
#[derive(Debug, Deserialize)]
pub struct Capabilities {
    /// The media service of profile S.
    #[serde(rename = "Media")]
    pub media: Option<CapabilityAddress>,
    /// The service of the motion.
    #[serde(rename = "PTZ")]
    pub ptz: Option<CapabilityAddress>,
}

/// Where a service is.
#[derive(Debug, Deserialize)]
pub struct CapabilityAddress {
    /// Its address.
    #[serde(rename = "XAddr")]
    pub address: String,
}

/// The body with the media profiles.
#[derive(Debug, Deserialize)]
pub struct ProfilesBody {
    /// The answer.
    #[serde(rename = "GetProfilesResponse")]
    pub answer: ProfilesAnswer,
}

/// The media profiles.
#[derive(Debug, Deserialize)]
pub struct ProfilesAnswer {
    /// In the camera's order: the main stream is mostly the first.
    #[serde(rename = "Profiles", default)]
    pub profiles: Vec<Profile>,
}

/// A media profile. The two versions of the service state the same in two places.
#[derive(Debug, Deserialize)]
pub struct Profile {
    /// Its name in requests.
    #[serde(rename = "@token")]
    pub token: String,
    /// Its name for people.
    #[serde(rename = "Name")]
    pub name: Option<String>,
    /// Where its picture comes from, as version 1 states it.
    #[serde(rename = "VideoSourceConfiguration")]
    source: Option<SourceConfiguration>,
    /// Its motion, as version 1 states it.
    #[serde(rename = "PTZConfiguration")]
    ptz: Option<Configuration>,
    /// Its parts, as version 2 states them.
    #[serde(rename = "Configurations")]
    configurations: Option<Configurations>,
}

#[derive(Debug, Deserialize)]
struct Configurations {
    #[serde(rename = "VideoSource")]
    source: Option<SourceConfiguration>,
    #[serde(rename = "PTZ")]
    ptz: Option<Configuration>,
}

#[derive(Debug, Deserialize)]
struct Configuration {
    #[serde(rename = "@token")]
    token: String,
}

#[derive(Debug, Deserialize)]
struct SourceConfiguration {
    #[serde(rename = "SourceToken")]
    token: String,
}

impl Profile {
    /// Whether it is called so, by its token or by its name.
    pub fn is_called(&self, text: &str) -> bool {
        self.token == text || self.name.as_deref() == Some(text)
    }

    /// The video source; `None`: the camera does not state it.
    pub fn source(&self) -> Option<&str> {
        let of_two = self.configurations.as_ref().and_then(|all| all.source.as_ref());
        self.source.as_ref().or(of_two).map(|source| source.token.as_str())
    }

    /// The configuration of its motion; `None`: it has none.
    pub fn motion(&self) -> Option<&str> {
        let of_two = self.configurations.as_ref().and_then(|all| all.ptz.as_ref());
        self.ptz.as_ref().or(of_two).map(|ptz| ptz.token.as_str())
    }
}

/// The body with the options of the motion.
#[derive(Debug, Deserialize)]
pub struct MoveOptionsBody {
    /// The answer.
    #[serde(rename = "GetConfigurationOptionsResponse")]
    pub answer: MoveOptionsAnswer,
}

/// The answer with the options of the motion.
#[derive(Debug, Deserialize)]
pub struct MoveOptionsAnswer {
    /// The options.
    #[serde(rename = "PTZConfigurationOptions")]
    pub options: MoveOptions,
}

/// The options of the motion.
#[derive(Debug, Deserialize)]
pub struct MoveOptions {
    /// The ranges.
    #[serde(rename = "Spaces")]
    pub spaces: Spaces,
    /// The time-outs.
    #[serde(rename = "PTZTimeout")]
    pub timeouts: Option<Timeouts>,
}

/// The ranges of the motion.
#[derive(Debug, Deserialize)]
pub struct Spaces {
    /// Those of the velocities; none: the camera cannot be turned at a speed.
    #[serde(rename = "ContinuousPanTiltVelocitySpace", default)]
    pub velocities: Vec<VelocitySpace>,
    /// Those of the zoom's velocities; none: the camera cannot zoom at a speed.
    #[serde(rename = "ContinuousZoomVelocitySpace", default)]
    pub zoom_velocities: Vec<ZoomVelocitySpace>,
}

/// A range of velocities.
#[derive(Debug, Deserialize)]
pub struct VelocitySpace {
    /// The name.
    #[serde(rename = "URI", default)]
    pub uri: String,
    /// Pan.
    #[serde(rename = "XRange")]
    pub pan: Range,
    /// Tilt.
    #[serde(rename = "YRange")]
    pub tilt: Range,
}

/// A range of the zoom's velocities.
#[derive(Debug, Deserialize)]
pub struct ZoomVelocitySpace {
    /// The name.
    #[serde(rename = "URI", default)]
    pub uri: String,
    /// The range.
    #[serde(rename = "XRange")]
    pub zoom: Range,
}

/// A range.
#[derive(Debug, Deserialize)]
pub struct Range {
    /// Its upper end.
    #[serde(rename = "Max")]
    pub max: f64,
}

/// The range of the time-outs, as ISO 8601 states durations.
#[derive(Debug, Deserialize)]
pub struct Timeouts {
    /// The least.
    #[serde(rename = "Min")]
    pub min: String,
    /// The largest.
    #[serde(rename = "Max")]
    pub max: String,
}

/// The body with the address of the video, of both versions.
#[derive(Debug, Deserialize)]
pub struct StreamUriBody {
    /// The answer.
    #[serde(rename = "GetStreamUriResponse")]
    pub answer: StreamUriAnswer,
}

/// The address of the video.
#[derive(Debug, Deserialize)]
pub struct StreamUriAnswer {
    #[serde(rename = "MediaUri")]
    media: Option<MediaUri>,
    #[serde(rename = "Uri")]
    uri: Option<String>,
}

#[derive(Debug, Deserialize)]
struct MediaUri {
    #[serde(rename = "Uri")]
    uri: String,
}

impl StreamUriAnswer {
    /// The address; `None`: there is none in the answer.
    pub fn address(self) -> Option<String> {
        self.media.map(|media| media.uri).or(self.uri).filter(|uri| !uri.is_empty())
    }
}

/// The body with the state of the motion.
#[derive(Debug, Deserialize)]
pub struct StatusBody {
    /// The answer.
    #[serde(rename = "GetStatusResponse")]
    pub answer: StatusAnswer,
}

/// The answer with the state of the motion.
#[derive(Debug, Deserialize)]
pub struct StatusAnswer {
    /// The state.
    #[serde(rename = "PTZStatus")]
    pub status: Status,
}

/// Where the camera points, and whether it moves. Many cameras tell neither.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Status {
    /// Where it points.
    #[serde(rename = "Position")]
    pub position: Option<Position>,
    /// Whether it moves.
    #[serde(rename = "MoveStatus")]
    pub moving: Option<MoveStatus>,
}

/// Where a camera points.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Position {
    /// Its two angles.
    #[serde(rename = "PanTilt")]
    pub pan_tilt: Option<PanTilt>,
}

/// Two angles, in the units of a space.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PanTilt {
    /// Pan, positive to the right.
    #[serde(rename = "@x")]
    pub pan: f64,
    /// Tilt, positive upwards.
    #[serde(rename = "@y")]
    pub tilt: f64,
    /// The space; `None`: that of -1 to 1.
    #[serde(rename = "@space")]
    pub space: Option<String>,
}

impl PanTilt {
    /// Whether both are degrees.
    pub fn is_degrees(&self) -> bool {
        self.space.as_ref().is_some_and(|space| space.ends_with("/SphericalPositionSpaceDegrees"))
    }
}

/// Whether a camera moves.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct MoveStatus {
    /// `IDLE`, `MOVING` or `UNKNOWN`.
    #[serde(rename = "PanTilt")]
    pub pan_tilt: Option<String>,
}
