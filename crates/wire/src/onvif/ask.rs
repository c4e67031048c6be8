//! What can be asked of a camera. A request that is not listed here cannot be sent: nothing is configured, no
//! preset is moved to or set, no user is made.

use core::time::Duration;

use quick_xml::escape::escape;

use super::velocity::{FullSpeeds, Velocity};
use crate::http::Lane;
use crate::http::motion::Speeds as _;

/// How long a motion lasts at most: its end is the camera's own dead-man's switch. Many cameras take whole
/// seconds alone.
pub const MOVE_TIMEOUT: Duration = Duration::from_secs(1);

const DEVICE: &str = "http://www.onvif.org/ver10/device/wsdl";
const MEDIA_1: &str = "http://www.onvif.org/ver10/media/wsdl";
const MEDIA_2: &str = "http://www.onvif.org/ver20/media/wsdl";
const PTZ: &str = "http://www.onvif.org/ver20/ptz/wsdl";
const SCHEMA: &str = "http://www.onvif.org/ver10/schema";

/// A version of the media service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Media {
    /// That of profile S.
    One,
    /// That of profile T.
    Two,
}

impl Media {
    /// The name of its namespace.
    pub const fn namespace(self) -> &'static str {
        match self {
            Self::One => MEDIA_1,
            Self::Two => MEDIA_2,
        }
    }
}

/// A service of a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Service {
    /// The device itself, which names the others.
    Device,
    /// Profiles and addresses of the video.
    Media(Media),
    /// Motion.
    Ptz,
}

impl Service {
    /// The name of its namespace.
    pub const fn namespace(self) -> &'static str {
        match self {
            Self::Device => DEVICE,
            Self::Media(media) => media.namespace(),
            Self::Ptz => PTZ,
        }
    }
}

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// The camera's time. No login is needed.
    DateAndTime,
    /// Where the services are.
    Services,
    /// The same, of cameras that do not know [`Ask::Services`].
    Capabilities,
    /// The media profiles.
    Profiles(Media),
    /// The address of a profile's video.
    StreamUri {
        /// The media service.
        media: Media,
        /// The profile.
        profile: String,
    },
    /// Ranges and time-outs of the motion.
    MoveOptions {
        /// The configuration of the profile's motion.
        configuration: String,
    },
    /// Where the camera points, and whether it moves.
    Status {
        /// The profile.
        profile: String,
    },
    /// Moves for a time.
    Move {
        /// The profile.
        profile: String,
        /// The velocity, -1 to 1 of the camera's range.
        velocity: Velocity,
        /// The ends of the camera's ranges.
        full: FullSpeeds,
        /// When the camera ends the motion by itself.
        timeout: Duration,
    },
    /// Ends the motion.
    Stop {
        /// The profile.
        profile: String,
    },
}

impl Ask {
    /// Whether it moves the camera, or may.
    pub fn is_motion(&self) -> bool {
        matches!(self, Self::Move { velocity, .. } if !velocity.is_rest())
    }

    /// The service that is asked.
    pub const fn service(&self) -> Service {
        match self {
            Self::DateAndTime | Self::Services | Self::Capabilities => Service::Device,
            Self::Profiles(media) | Self::StreamUri { media, .. } => Service::Media(*media),
            Self::MoveOptions { .. } | Self::Status { .. } | Self::Move { .. } | Self::Stop { .. } => {
                Service::Ptz
            }
        }
    }

    /// The lane on which it is sent, unless another one is free.
    pub const fn lane(&self) -> Lane {
        match self {
            Self::Move { .. } => Lane::Turn,
            Self::Stop { .. } => Lane::Stop,
            Self::Status { .. } => Lane::Camera,
            _ => Lane::State,
        }
    }

    /// The body of the message.
    pub fn body(&self) -> String {
        let (name, content) = match self {
            Self::DateAndTime => ("GetSystemDateAndTime", String::new()),
            Self::Services => ("GetServices", element("IncludeCapability", "false")),
            Self::Capabilities => ("GetCapabilities", element("Category", "All")),
            Self::Profiles(Media::One) => ("GetProfiles", String::new()),
            Self::Profiles(Media::Two) => ("GetProfiles", element("Type", "All")),
            Self::StreamUri { media: Media::One, profile } => (
                "GetStreamUri",
                format!(
                    "<q:StreamSetup><t:Stream>RTP-Unicast</t:Stream><t:Transport><t:Protocol>RTSP</t:Protocol>\
                     </t:Transport></q:StreamSetup>{}",
                    element("ProfileToken", profile)
                ),
            ),
            Self::StreamUri { media: Media::Two, profile } => {
                ("GetStreamUri", element("Protocol", "RTSP") + &element("ProfileToken", profile))
            }
            Self::MoveOptions { configuration } => {
                ("GetConfigurationOptions", element("ConfigurationToken", configuration))
            }
            Self::Status { profile } => ("GetStatus", element("ProfileToken", profile)),
            Self::Stop { profile } => (
                "Stop",
                element("ProfileToken", profile) + &element("PanTilt", "true") + &element("Zoom", "true"),
            ),
            Self::Move { profile, velocity, full, timeout } => {
                let shares = velocity.shares();
                let zoom = full
                    .zoom
                    .map_or_else(String::new, |full| format!("<t:Zoom x=\"{}\"/>", shares.zoom * full));
                let content = format!(
                    "{}<q:Velocity><t:PanTilt x=\"{}\" y=\"{}\"/>{zoom}</q:Velocity>{}",
                    element("ProfileToken", profile),
                    shares.pan * full.pan,
                    shares.tilt * full.tilt,
                    element("Timeout", &format!("PT{}S", timeout.as_millis() as f64 / 1e3)),
                );
                ("ContinuousMove", content)
            }
        };
        let namespace = self.service().namespace();
        format!("<q:{name} xmlns:q=\"{namespace}\" xmlns:t=\"{SCHEMA}\">{content}</q:{name}>")
    }
}

fn element(name: &str, content: &str) -> String {
    format!("<q:{name}>{}</q:{name}>", escape(content))
}
