//! The tracking camera in the configuration.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Result, bail};
use barrelman_vocab::mavlink::{ComponentId, SystemId};
use barrelman_wire::mavlink::tracking_camera::CameraSettings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::range::within;

/// Longest delay of a ground station's picture, seconds: so long are video frames kept.
const MAX_DISPLAY_DELAY_S: f64 = 1.5;

/// Barrelman as a tracking camera on a MAVLink link.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrackingCameraSection {
    /// Where ground stations are: `udp://host:port`, `tcp://host:port` or `serial:/dev/ttyACM0?baud=57600`; without an address
    /// there is no tracking camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// System id of the vehicle that the camera belongs to, 1 to 255; default: that of the first autopilot that is heard, and 1
    /// until then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub system_id: Option<u8>,
    /// Component id of the camera, 1 to 255; default: 100, the first camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component_id: Option<u8>,
    /// Whether a predicted place is marked as coasting; default: false, since ground stations draw nothing then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marks_coasting: Option<bool>,
    /// How much older the picture of the ground station is than the newest video frame here, seconds, 0 to 1.5; default: 0. A
    /// selection is made on the video frame of that time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub display_delay_s: Option<f64>,
    /// File whose first line is the key of signed packets, 64 hexadecimal digits or a passphrase; default: packets are not
    /// signed.
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
    ///
    /// # Errors
    /// If a value is out of range; the message names the key and the range.
    pub(super) fn resolve(&self) -> Result<TrackingCameraConfig> {
        for (key, id) in [("system_id", self.system_id), ("component_id", self.component_id)] {
            if id == Some(0) {
                bail!("tracking_camera.{key} = 0: use 1 to 255; 0 addresses everybody");
            }
        }
        let default = CameraSettings::DEFAULT;
        let delay_s = within(
            "tracking_camera.display_delay_s",
            self.display_delay_s,
            0.0,
            0.0,
            MAX_DISPLAY_DELAY_S,
            "seconds",
        )?;
        Ok(TrackingCameraConfig {
            url: self.url.clone(),
            settings: CameraSettings {
                system: self.system_id.map(SystemId),
                component: self.component_id.map_or(default.component, ComponentId),
                marks_coasting: self.marks_coasting.unwrap_or(default.marks_coasting),
            },
            display_delay: Duration::from_secs_f64(delay_s),
            signing_key_file: self.signing_key_file.clone(),
        })
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
