//! The configuration file as written: every key may be left out.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::camera::CameraSection;
use super::tracker::TrackerSection;
use barrelman_experiments::law_choice::{LawName, ModeName};

/// A configuration file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ConfigFile {
    /// Where the video comes from.
    pub video: VideoSection,
    /// Where the commands go.
    pub link: LinkSection,
    /// The vehicle.
    pub vehicle: VehicleSection,
    /// How its camera answers.
    pub camera: CameraSection,
    /// The camera law.
    pub law: LawSection,
    /// The tracker.
    pub tracker: TrackerSection,
}

/// The camera law.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LawSection {
    /// Its name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<LawName>,
    /// What the optimal law spares.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<ModeName>,
    /// Within what time the optimal law brings the target back, seconds, 0.5 to 5; without it the mode's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon: Option<f64>,
}

/// Where the video comes from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VideoSection {
    /// `rtsp://...` or `file:...`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// File whose first line is the camera's `user:password`, for `rtsp://` alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub login_file: Option<PathBuf>,
    /// Name of the environment variable that holds the camera's `user:password`, for `rtsp://` alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub login_env: Option<String>,
}

/// Where the commands go.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LinkSection {
    /// `serial:/dev/ttyACM0?baud=115200` or `tcp://host:port`; without it: a dry run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// What stands around a line to a Fotokite Pro.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line_ending: Option<LineEnding>,
}

/// What stands around a line to a Fotokite Pro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LineEnding {
    /// A carriage return before and after.
    CrAround,
    /// A line feed after.
    Lf,
}

/// Which way the vehicle counts a rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SignName {
    /// As we do: positive turns the view right, or raises it.
    Same,
    /// The other way.
    Opposite,
}

/// The vehicle: a profile, and what differs from it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleSection {
    /// Name of the profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// Horizontal semi-axis of the region, share of half the picture's width.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region_half_width: Option<f64>,
    /// Vertical semi-axis of the region, share of half the picture's height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region_half_height: Option<f64>,
    /// The motor schema's pan rate, rad/s, 0 to the pan limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub schema_pan_rad_per_s: Option<f64>,
    /// The motor schema's tilt rate, rad/s, 0 to the tilt limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub schema_tilt_rad_per_s: Option<f64>,
    /// The largest pan rate that may be sent, rad/s, 0 to 0.4 (Fotokite Pro).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_pan_rad_per_s: Option<f64>,
    /// The largest tilt rate that may be sent, rad/s, 0 to 0.3 (Fotokite Pro).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_tilt_rad_per_s: Option<f64>,
    /// The vehicle's yaw rate against our pan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_sign: Option<SignName>,
    /// The vehicle's pitch rate against our tilt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_sign: Option<SignName>,
    /// Nominal time from the sensor to the arrival of a video frame, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub video_latency_s: Option<f64>,
    /// How much older than that a video frame may arrive before it counts as stale, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stale_after_s: Option<f64>,
    /// How long a rate may last after the last fresh localisation arrived, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coast_motion_s: Option<f64>,
}
