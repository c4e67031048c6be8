//! The form of a scenario file (TOML).

use serde::Deserialize;
use std::collections::BTreeMap;

/// A scenario file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// Name of the scenario.
    pub name: String,
    /// Summary in one line.
    pub summary: String,
    /// Default setting: a name in `sway` or `kite`.
    pub setting: String,
    /// Maximum duration of a trial, seconds.
    pub longest_s: f64,
    /// The camera.
    pub camera: CameraSection,
    /// The pan axis.
    pub pan: AxisSection,
    /// The tilt axis.
    pub tilt: AxisSection,
    /// Intervals of the plant for `--plant drawn`.
    pub drawn: SampledSection,
    /// Sway of the camera's carrier, by the names of settings.
    #[serde(default)]
    pub sway: BTreeMap<String, SwaySection>,
    /// A kite on its line in the wind, by the names of settings.
    #[serde(default)]
    pub kite: BTreeMap<String, KiteSection>,
    /// The water; without it, the laboratory's floor.
    pub water: Option<WaterSection>,
    /// The light.
    pub light: LightSection,
    /// A target that is moved along a path. A scenario has either a target or a boat.
    pub target: Option<TargetSection>,
    /// A boat that is driven along a path.
    pub boat: Option<BoatSection>,
    /// Whether there are marks along the path.
    pub marks: bool,
    /// Objects beside the target.
    #[serde(default)]
    pub object: Vec<SceneObjectSection>,
    /// Localisations without pixels.
    pub sensing: SensingSection,
}

/// The camera.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSection {
    /// Height above floor or water, metres.
    pub height_m: f64,
    /// Width and height of the picture, pixels.
    pub picture: [u32; 2],
    /// Width and height of the frame around the picture, pixels; without it, those of the picture.
    pub frame: Option<[u32; 2]>,
    /// Focal length, pixels.
    pub focal_px: f64,
    /// Coefficient of the barrel distortion.
    #[serde(default)]
    pub barrel: f64,
    /// Pictures per second.
    pub pictures_per_second: u32,
    /// Time from the readout of the first row to that of the last, seconds.
    #[serde(default)]
    pub rolling_shutter_s: f64,
    /// Exposure of each row, seconds.
    pub exposure_s: f64,
    /// Standard deviation of the drift of the brightness, a share.
    pub brightness_drift: f64,
    /// Time constant of the drift of the brightness, seconds.
    pub brightness_time_s: f64,
    /// Standard deviation of the drift of the gains of red and blue, a share.
    pub white_balance_drift: f64,
    /// Time constant of the drift of the gains, seconds.
    pub white_balance_time_s: f64,
    /// From capture to arrival, seconds.
    pub latency_s: f64,
    /// Random addition to the latency, seconds.
    #[serde(default)]
    pub latency_jitter_s: f64,
    /// Lost and frozen pictures; without it, none.
    pub loss: Option<LossSection>,
    /// Mean error of the first view, pan and tilt, radians.
    #[serde(default)]
    pub first_view_rad: [f64; 2],
    /// Standard deviation of that error, radians.
    pub first_view_deviation_rad: [f64; 2],
    /// The zoom; without it, the camera has none.
    pub zoom: Option<ZoomSection>,
}

/// The zoom. The focal length of the camera is that of its widest view.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZoomSection {
    /// Focal length of the closest view over that of the widest.
    pub ratio: f64,
    /// Largest rate: the change of the focal length's logarithm in a second.
    pub limit_per_s: f64,
    /// Time from a command to its effect in the picture, seconds. It includes the latency of the camera.
    pub dead_time_s: f64,
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisSection {
    /// Time from a command to move to the motion in the picture, seconds. It includes the latency of the
    /// camera.
    pub start_dead_time_s: f64,
    /// Time from a zero rate to the stop in the picture, seconds. It includes the latency of the camera.
    pub stop_dead_time_s: f64,
    /// Time constant, seconds.
    pub lag_s: f64,
    /// Largest rate, rad/s.
    pub limit_rad_per_s: f64,
    /// End stops, degrees; without it, none.
    pub stops_deg: Option<[f64; 2]>,
    /// Maximum acceleration, rad/s²; without it, only the lag limits the acceleration.
    pub acceleration_rad_per_s2: Option<f64>,
    /// Dead band: a smaller rate does not move the axis, rad/s.
    #[serde(default)]
    pub dead_band_rad_per_s: f64,
}

/// Lost and frozen pictures (a link with a good and a bad state).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LossSection {
    /// Probability per picture that a good link becomes bad.
    pub to_bad: f64,
    /// Probability per picture that a bad link becomes good.
    pub to_good: f64,
    /// Share of the pictures of a bad link that are lost or frozen.
    pub spoilt: f64,
    /// Share of these that repeat the picture before; the others are lost.
    pub frozen: f64,
}

/// A kite on its line.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KiteSection {
    /// Factor of the frequency and the strength of gusts; 1 is the usual wind.
    pub gustiness: f64,
}

/// The water and the wind over it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaterSection {
    /// Sea state, 0 (glassy) to 4 (moderate).
    pub sea_state: u8,
    /// Mean wind, m/s; without it, the wind that raises this sea.
    pub wind_m_per_s: Option<f64>,
    /// Direction to which the wind blows, degrees: 0 along x, anticlockwise.
    pub wind_towards_deg: f64,
    /// Steady current along x and y, m/s.
    #[serde(default)]
    pub current_m_per_s: [f64; 2],
}

/// The light.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightSection {
    /// Bearing of the sun, degrees: 0 ahead of the first view, positive to the right.
    pub sun_bearing_deg: f64,
    /// Elevation of the sun above the horizon, degrees.
    pub sun_elevation_deg: f64,
    /// Cloud cover, 0 (clear) to 1 (overcast).
    pub overcast: f64,
}

/// A boat that is driven along a path.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoatSection {
    /// Name of a built-in path.
    pub path: Option<String>,
    /// Way-points, metres, instead of a built-in path.
    pub way_points: Option<Vec<[f64; 2]>>,
    /// Scale of the path.
    pub scale: f64,
    /// What steers the boat.
    #[serde(default)]
    pub steering: SteeringName,
    /// Median speed of the trials, m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the logarithm of the speed.
    pub speed_spread: f64,
    /// Maximum throttle, 0 to 1.
    pub most_throttle: f64,
    /// Look-ahead distance on the path, metres.
    pub look_ahead_m: f64,
    /// Standard deviation of each way-point, metres.
    pub way_point_jitter_m: f64,
}

/// What steers a boat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SteeringName {
    /// The nozzle of the jet.
    #[default]
    Jet,
    /// The nozzle, and a rudder beside the jet.
    JetAndRudder,
}

/// An object beside the target.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneObjectSection {
    /// Kind of the object.
    pub kind: SceneObjectName,
    /// Position, metres.
    pub at: [f64; 2],
    /// Standard deviation of the position from trial to trial, metres.
    #[serde(default)]
    pub jitter_m: f64,
    /// Heading, degrees: 0 along x, anticlockwise.
    #[serde(default)]
    pub heading_deg: f64,
    /// Velocity along x and y, m/s.
    #[serde(default)]
    pub velocity_m_per_s: [f64; 2],
    /// Time after which the object reverses its velocity, again and again, seconds.
    pub turns_after_s: Option<f64>,
    /// Whether the object drifts with the current, the waves and a little with the wind.
    #[serde(default)]
    pub drifts: bool,
    /// Length and breadth of a pier, metres.
    pub size_m: Option<[f64; 2]>,
}

/// The kinds of objects beside the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SceneObjectName {
    /// A buoy.
    Buoy,
    /// A life jacket adrift.
    LifeJacket,
    /// A person in the water.
    Swimmer,
    /// Another craft in the boat's colour.
    RedCraft,
    /// A pier.
    Pier,
    /// A shore.
    Shore,
}

/// Intervals of the sampled parameters of the plant.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampledSection {
    /// Focal length, pixels.
    pub focal_px: [f64; 2],
    /// Pan.
    pub pan: SampledAxisSection,
    /// Tilt.
    pub tilt: SampledAxisSection,
    /// Cross-talk: share of an axis's rate that also turns the other axis; without it, the nominal value.
    pub cross_talk: Option<[f64; 2]>,
    /// Rate at which the tilt sinks, degrees per second; without it, the nominal value.
    pub droop_deg_per_s: Option<[f64; 2]>,
}

/// Intervals of the sampled parameters of an axis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampledAxisSection {
    /// As in [`AxisSection`], seconds.
    pub start_dead_time_s: [f64; 2],
    /// As in [`AxisSection`], seconds.
    pub stop_dead_time_s: [f64; 2],
    /// As in [`AxisSection`], seconds.
    pub lag_s: [f64; 2],
    /// Gain: actual rate over commanded rate; without it, 1.
    pub gain: Option<[f64; 2]>,
}

/// Sway of the carrier: standard deviations and time constants.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SwaySection {
    /// Standard deviation of the yaw, degrees.
    pub yaw_deg: f64,
    /// Time constant of the yaw, seconds.
    pub yaw_time_s: f64,
    /// Standard deviation of the pitch, degrees.
    pub pitch_deg: f64,
    /// Time constant of the pitch, seconds.
    pub pitch_time_s: f64,
    /// Standard deviation of the roll, degrees.
    pub roll_deg: f64,
    /// Time constant of the roll, seconds.
    pub roll_time_s: f64,
    /// Standard deviation of the position in each coordinate, metres.
    pub place_m: f64,
    /// Time constant of the position, seconds.
    pub place_time_s: f64,
}

/// A target that is moved along a path.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetSection {
    /// Name of a built-in path.
    pub path: Option<String>,
    /// Way-points, metres, instead of a built-in path.
    pub way_points: Option<Vec<[f64; 2]>>,
    /// A way-point before the first of the path; without it, the path starts with its first way-point.
    pub start_m: Option<[f64; 2]>,
    /// Scale of the path.
    pub scale: f64,
    /// Additional scale of x; without it, 1.
    pub breadth: Option<f64>,
    /// Median speed of the trials, m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the logarithm of the trials' speeds.
    pub speed_spread: f64,
    /// Standard deviation of the logarithm of the speed during a trial.
    pub gust_share: f64,
    /// Time constant of the speed's variation, seconds.
    pub gust_time_s: f64,
    /// Standard deviation of the weaving of the heading, radians.
    #[serde(default)]
    pub weave_rad: f64,
    /// Time constant of the weaving, seconds.
    #[serde(default = "one_second")]
    pub weave_time_s: f64,
    /// Look-ahead distance on the path, metres.
    pub look_ahead_m: f64,
    /// Standard deviation of each way-point, metres.
    pub way_point_jitter_m: f64,
    /// Turn rate per radian of heading error, 1/s.
    pub heading_gain: f64,
    /// Maximum turn rate, rad/s.
    pub most_turn_rad_per_s: f64,
    /// Time constant of the speed, seconds.
    pub surge_lag_s: f64,
    /// Time constant of the turn rate, seconds.
    pub turn_lag_s: f64,
    /// Reduction of the speed in a corner of 90 degrees, a share.
    pub corner_slow_down: f64,
    /// Distance before the end of the path over which the target comes to rest, metres.
    #[serde(default)]
    pub arrival_m: f64,
    /// Mean time at rest before the start, seconds.
    pub stand_before_s: f64,
    /// Mean time at rest at the end, seconds.
    pub stand_after_s: f64,
    /// Pauses per second under way.
    pub pauses_per_s: f64,
    /// Share of the path's corners with an additional pause, 0 to 1.
    #[serde(default)]
    pub corner_pauses: f64,
    /// Reduction of the speed at both ends of each leg from corner to corner, a share from 0 to 1.
    #[serde(default)]
    pub leg_rhythm: f64,
    /// Exponent of the horizontal distance from the camera in the speed, 0 to 1.
    #[serde(default)]
    pub range_exponent: f64,
    /// Mean duration of a pause, seconds.
    pub pause_s: f64,
}

/// Localisations without pixels.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensingSection {
    /// Length and breadth of the target, metres.
    pub target_size_m: [f64; 2],
    /// Standard deviation, pixels.
    pub noise_px: f64,
    /// Time constant of the noise, seconds; 0 for independent noise of each picture.
    #[serde(default)]
    pub noise_time_s: f64,
    /// Standard deviation of the bow's direction in the picture, degrees. Without it the direction is not
    /// measured.
    pub heading_noise_deg: Option<f64>,
    /// Whether the position is rounded to whole pixels.
    pub rounded: bool,
    /// Limits of |x| and |y|, pixels: a target outside of the picture is reported at the limit. Without them
    /// it is lost.
    pub clamped_at_px: Option<[f64; 2]>,
}

/// A path file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathFile {
    /// Way-points, metres.
    pub way_points: Vec<[f64; 2]>,
}

const fn one_second() -> f64 {
    1.0
}
