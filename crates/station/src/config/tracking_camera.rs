//! The tracking camera in the configuration.

use std::path::PathBuf;
use std::time::Duration;

use barrelman_vocab::mavlink::{ComponentId, SystemId};
use barrelman_wire::mavlink::tracking_camera::CameraSettings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Barrelman as a tracking camera on a MAVLink link.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrackingCameraSection {
    /// Where ground stations are: `udp://host:port`, `tcp://host:port` or `serial:/dev/ttyACM0?baud=57600`;
    /// without an address there is no tracking camera.
    #[schemars(example = "udp://127.0.0.1:14550")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// System id of the vehicle that the camera belongs to; default: that of the first autopilot that is
    /// heard, and 1 until then.
    #[schemars(range(min = 1, max = 255))]
    #[schemars(example = 1)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub system_id: Option<u8>,
    /// Component id of the camera; ground stations look for cameras at 100 to 105.
    #[schemars(range(min = 1, max = 255))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component_id: Option<u8>,
    /// Whether a predicted place is marked as coasting. Ground stations of 2026 draw nothing then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marks_coasting: Option<bool>,
    /// How much older the picture of the ground station is than the newest video frame here, seconds. A
    /// selection is made on the video frame of that time.
    #[schemars(range(min = 0.0, max = 1.5))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub display_delay_s: Option<f64>,
    /// File whose first line is the key of signed packets, 64 hexadecimal digits or a passphrase; default:
    /// packets are not signed.
    #[schemars(example = "/etc/barrelman/mavlink-key")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signing_key_file: Option<PathBuf>,
}

/// The effective settings of the tracking camera.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackingCameraConfig {
    /// Where ground stations are; `None`: there is no tracking camera.
    pub url: Option<String>,
    /// How the camera appears.
    pub settings: CameraSettings,
    /// How much older the picture of a ground station is.
    pub display_delay: Duration,
    /// The file of the key of signed packets.
    pub signing_key_file: Option<PathBuf>,
}

impl TrackingCameraSection {
    /// The effective settings.
    pub(super) fn resolve(&self) -> TrackingCameraConfig {
        let default = CameraSettings::DEFAULT;
        TrackingCameraConfig {
            url: self.url.clone(),
            settings: CameraSettings {
                system: self.system_id.map(SystemId),
                component: self.component_id.map_or(default.component, ComponentId),
                marks_coasting: self.marks_coasting.unwrap_or(default.marks_coasting),
            },
            display_delay: self.display_delay_s.map_or(Duration::ZERO, Duration::from_secs_f64),
            signing_key_file: self.signing_key_file.clone(),
        }
    }

    /// A complete section.
    pub(super) fn from_config(config: &TrackingCameraConfig) -> Self {
        let settings = config.settings;
        Self {
            url: config.url.clone(),
            system_id: settings.system.map(|system| system.0),
            component_id: Some(settings.component.0),
            marks_coasting: Some(settings.marks_coasting),
            display_delay_s: Some(config.display_delay.as_secs_f64()),
            signing_key_file: config.signing_key_file.clone(),
        }
    }
}
