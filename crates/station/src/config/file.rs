//! The configuration file as written: every key is optional.

use std::path::PathBuf;

use barrelman_control::OptimalSettings;
use barrelman_video::engine::VideoEngine;
use barrelman_video::sender_clock::ClockChoice;
use barrelman_vocab::profile::MAX_COAST_MOTION;
use barrelman_vocab::{Framed, LawName, OptimalMode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::camera::CameraSection;
use super::console::{ConsoleSection, RecordingSection};
use super::detector::DetectorSection;
use super::share::ShareSection;
use super::speeds::SpeedsSection;
use super::tak::TakSection;
use super::tracker::TrackerSection;
use super::tracking_camera::TrackingCameraSection;
use super::vessel::VesselSection;

/// A configuration file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ConfigFile {
    /// The video source.
    pub video: VideoSection,
    /// The vehicle's link.
    pub link: LinkSection,
    /// The vehicle.
    pub vehicle: VehicleSection,
    /// The vehicle's camera.
    pub camera: CameraSection,
    /// The camera law.
    pub law: LawSection,
    /// The tracker.
    pub tracker: TrackerSection,
    /// Barrelman as a tracking camera on a MAVLink link.
    pub tracking_camera: TrackingCameraSection,
    /// Boat, camera and marks on the maps of TAK displays.
    pub tak: TakSection,
    /// The annotated live video for other programs.
    pub share: ShareSection,
    /// A detector of your own, which says what the numbered objects are.
    pub detector: DetectorSection,
    /// The boat.
    pub vessel: VesselSection,
    /// The operator's console.
    pub console: ConsoleSection,
    /// The recordings that `run` makes without being asked.
    pub recording: RecordingSection,
}

/// The camera law.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LawSection {
    /// The law's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<LawName>,
    /// What the optimal law saves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<OptimalMode>,
    /// Horizon of the optimal law: the time within which it brings the target back, seconds; default: the
    /// mode's.
    #[schemars(range(min = *OptimalSettings::HORIZONS_S.start(), max = *OptimalSettings::HORIZONS_S.end()))]
    #[schemars(example = 1.73)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
    /// What the optimal law shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<Framed>,
}

/// The video source.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VideoSection {
    /// Address: `rtsp://...`, `udp://0.0.0.0:5600`, `/dev/video0`, a file, `sim:...` or another of those that
    /// docs/video.md lists.
    #[schemars(example = "rtsp://camera.example/live")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// Address of a second video, as `url` but for `sim:`: another camera on the same vehicle, which the page
    /// shows, too, and in which the boat can be followed instead.
    #[schemars(example = "rtsp://camera.example/thermal")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_url: Option<String>,
    /// Horizontal field of view of the second video, degrees, of a camera that does not zoom; default: that of
    /// the first, whatever its zoom.
    #[schemars(range(min = 1.0, max = 170.0), example = 40.0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_field_of_view_deg: Option<f64>,
    /// File whose first line is the camera's `user:password`, only for `rtsp://` and `rtsps://`. A second
    /// line `host HOST:PORT` says who alone gets the login: a vehicle that names its video gets none without
    /// it.
    #[schemars(example = "/etc/barrelman/camera-login")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub login_file: Option<PathBuf>,
    /// Name of the environment variable that holds the camera's `user:password`, only for `rtsp://`.
    #[schemars(example = &"BARRELMAN_CAMERA_LOGIN")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub login_env: Option<String>,
    /// The vehicle's own video, by its name there, where the vehicle has several: a stream of a Sigma, or a
    /// media profile of an ONVIF camera, which is then also the one that is moved. `check` lists them;
    /// default: the main one.
    #[schemars(example = &"overview")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stream: Option<String>,
    /// Which clock gives the times of capture of a stream.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock: Option<ClockChoice>,
    /// Which engine reads and decodes the video. GStreamer is a program of its own, `barrelman-media`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine: Option<VideoEngine>,
    /// Whether a password may be sent in clear text (Basic) to a camera without TLS that takes nothing else:
    /// everybody on the network can read it then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allow_basic_login: Option<bool>,
    /// SHA-256 fingerprint of the certificate of a camera at `rtsps://`, 64 hexadecimal digits: no other one
    /// is accepted.
    #[schemars(example = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificate_sha256: Option<String>,
    /// File of authorities (PEM) that sign the certificate of a camera at `rtsps://`; default: the well-known
    /// ones.
    #[schemars(example = "/etc/barrelman/authority.pem")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ca_file: Option<PathBuf>,
}

/// The vehicle's link.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LinkSection {
    /// Address: `serial:/dev/ttyACM0?baud=115200`, `tcp://host:port`, `udp://host:port`,
    /// `http://host:port/api`, `https://host/api` or `onvif://host`; without an address: a dry run.
    #[schemars(example = "serial:/dev/ttyACM0?baud=115200")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// The guard's program; default: `barrelman-guard` beside the program.
    #[schemars(example = "/usr/local/bin/barrelman-guard")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guard: Option<PathBuf>,
    /// Whether to run without the guard, also where the vehicle keeps its last rate when the program is gone:
    /// the camera then goes on turning, and the boat goes on until its own time-out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_guard: Option<bool>,
    /// File whose first line is the access token of a vehicle at `http://` or `https://`, or `api-key ` and
    /// an API key.
    #[schemars(example = "/etc/barrelman/sigma-token")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub token_file: Option<PathBuf>,
    /// File whose first line is the `user:password` of a camera at `onvif://` or `onvifs://`; default: the
    /// camera asks for none.
    #[schemars(example = "/etc/barrelman/camera-login")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub login_file: Option<PathBuf>,
    /// SHA-256 fingerprint of the certificate of a vehicle at `https://` or `onvifs://`, 64 hexadecimal
    /// digits: no other one is accepted.
    #[schemars(example = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificate_sha256: Option<String>,
    /// File of authorities (PEM) that sign the certificate of a vehicle at `https://`; default: the
    /// well-known ones.
    #[schemars(example = "/etc/barrelman/authority.pem")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ca_file: Option<PathBuf>,
    /// The host beside that of `url` on which a vehicle at `http://` or `https://` may name its video;
    /// default: none.
    #[schemars(example = "camera.example")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub video_host: Option<String>,
    /// Delimiters of a line, where the vehicle takes lines of text (Fotokite Pro).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line_ending: Option<LineEnding>,
    /// This program's own system id; default: 245. Together with the component id no other part of the link
    /// may have it (MAVLink).
    #[schemars(range(min = 1, max = 255))]
    #[schemars(example = 245)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub system_id: Option<u8>,
    /// This program's own component id; default: 191, an onboard computer (MAVLink).
    #[schemars(range(min = 1, max = 255))]
    #[schemars(example = 191)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component_id: Option<u8>,
    /// System id of the vehicle whose gimbal is moved; default: the first that has a gimbal (MAVLink).
    #[schemars(range(min = 1, max = 255))]
    #[schemars(example = 1)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vehicle_system: Option<u8>,
    /// File whose first line is the key of signed packets, 64 hexadecimal digits or a passphrase (MAVLink).
    /// With it, packets that are not signed with this key are not read; default: packets are not signed.
    #[schemars(example = "/etc/barrelman/mavlink-key")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signing_key_file: Option<PathBuf>,
}

/// Delimiters of a line of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LineEnding {
    /// A carriage return before and after.
    CrAround,
    /// A line feed after.
    Lf,
}

/// Sign of a vehicle's rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SignName {
    /// This program's sign: a positive rate turns the view right, or raises it.
    Same,
    /// The opposite sign.
    Opposite,
}

/// The vehicle: a profile, and values that override the profile's.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleSection {
    /// Name of the profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// Horizontal semi-axis of the region, share of half the picture's width.
    #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "a share"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region_half_width: Option<f64>,
    /// Vertical semi-axis of the region, share of half the picture's height.
    #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "a share"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region_half_height: Option<f64>,
    /// The motor schema's pan rate, rad/s, 0 to the pan limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub schema_pan_rad_per_s: Option<f64>,
    /// The motor schema's tilt rate, rad/s, 0 to the tilt limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub schema_tilt_rad_per_s: Option<f64>,
    /// The largest pan rate that may be sent, rad/s, 0 to 0.4 (Fotokite Pro), 0.436 (Fotokite Sigma) or 0.5
    /// (others).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_pan_rad_per_s: Option<f64>,
    /// The largest tilt rate that may be sent, rad/s, 0 to 0.3 (Fotokite Pro), 0.436 (Fotokite Sigma) or 0.5
    /// (others).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_tilt_rad_per_s: Option<f64>,
    /// Sign of the vehicle's yaw rate relative to pan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_sign: Option<SignName>,
    /// Sign of the vehicle's pitch rate relative to tilt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_sign: Option<SignName>,
    /// Nominal latency of the video, from the sensor to the arrival of a frame, seconds.
    #[schemars(range(min = 0.0, max = 5.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub video_latency_s: Option<f64>,
    /// Latency beyond the nominal latency from which on a video frame counts as stale, seconds.
    #[schemars(range(min = 0.0, max = 5.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stale_after_s: Option<f64>,
    /// How long a rate may last after the arrival of the last fresh localisation, seconds.
    #[schemars(range(min = 0.05, max = MAX_COAST_MOTION.as_secs_f64()))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coast_motion_s: Option<f64>,
    /// Net yaw from which on the operator is warned that the tether winds up, radians.
    #[schemars(range(min = 0.5, max = 100.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub net_yaw_warn_rad: Option<f64>,
    /// Net yaw from which on the vehicle turns back only, radians.
    #[schemars(range(min = 0.5, max = 100.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub net_yaw_limit_rad: Option<f64>,
    /// Sense of the yaw in the reported attitude, relative to a turn to the right; without it, the reports
    /// are not used.
    #[schemars(example = &"opposite")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attitude_yaw_sign: Option<SignName>,
    /// MAVLink gimbal: the number of the gimbal device that is moved, 1 to 6 (154, 171 to 175: a gimbal that
    /// is a component of its own); 0, the default, is the first one that can pan and tilt.
    #[schemars(range(min = 0, max = 175))]
    #[schemars(example = 0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gimbal_device: Option<u8>,
    /// Component of the MAVLink camera that zooms, where `camera.zoom.ratio` is above 1: 100, the default, to
    /// 105; 1 is the autopilot's own.
    #[schemars(range(min = 1, max = 105))]
    #[schemars(example = 100)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<u8>,
    /// Which angle of the gimbal's reported attitude is the tilt; without it, the reports are not used.
    /// `barrelman calibrate axes` finds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gimbal_tilt: Option<GimbalTiltSection>,
    /// How fast the camera turns at its speeds, where those have no unit (ONVIF).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speeds: Option<SpeedsSection>,
}

/// The tilt in the reported attitude of a gimbal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GimbalTiltSection {
    /// The angle of the reported quaternion.
    #[schemars(example = &"pitch")]
    pub axis: EulerName,
    /// Sense of that angle, relative to a tilt upwards.
    #[schemars(example = &"opposite")]
    pub sign: SignName,
    /// Tilt at which that angle is zero, radians.
    #[schemars(range(min = -1.571, max = 1.571))]
    #[schemars(example = 0.0)]
    pub zero_rad: f64,
}

/// An Euler angle of a quaternion (turned about z, y, x, in this order).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EulerName {
    /// About x.
    Roll,
    /// About y.
    Pitch,
    /// About z.
    Yaw,
}
