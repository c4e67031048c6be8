//! A scenario's file as written.

use serde::Deserialize;
use std::collections::BTreeMap;

/// A scenario's file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// What it is called.
    pub name: String,
    /// What it is about, in one line.
    pub summary: String,
    /// Which of `sway` it has unless something else is asked for.
    pub setting: String,
    /// No trial lasts longer, seconds.
    pub longest_s: f64,
    /// The camera.
    pub camera: CameraSection,
    /// Its axes.
    pub pan: AxisSection,
    /// Its axes.
    pub tilt: AxisSection,
    /// What of the plant is drawn with `--plant drawn`.
    pub drawn: SampledSection,
    /// How the kite sways, by the names of settings.
    #[serde(default)]
    pub sway: BTreeMap<String, SwaySection>,
    /// Or a kite on its line in the wind, by the names of settings.
    #[serde(default)]
    pub kite: BTreeMap<String, KiteSection>,
    /// The water; left out: the laboratory's floor.
    pub water: Option<WaterSection>,
    /// The light.
    pub light: LightSection,
    /// The target: something that is moved along a path,
    pub target: Option<TargetSection>,
    /// or a boat that is driven along one.
    pub boat: Option<BoatSection>,
    /// Whether the path's way-points are marked.
    pub marks: bool,
    /// What else there is.
    #[serde(default)]
    pub thing: Vec<SceneObjectSection>,
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
    /// Width and height of the frame around it, pixels; left out: the picture's.
    pub frame: Option<[u32; 2]>,
    /// Focal length, pixels.
    pub focal_px: f64,
    /// Barrel distortion.
    #[serde(default)]
    pub barrel: f64,
    /// Pictures per second.
    pub pictures_per_second: u32,
    /// From the first row to the last, seconds.
    #[serde(default)]
    pub rolling_shutter_s: f64,
    /// How long each row is exposed, seconds.
    pub exposure_s: f64,
    /// Drift of the brightness, and of the gains of red and blue: shares, and the times after which it is forgotten.
    pub brightness_drift: f64,
    /// Seconds.
    pub brightness_time_s: f64,
    /// A share.
    pub white_balance_drift: f64,
    /// Seconds.
    pub white_balance_time_s: f64,
    /// From capture to arrival, seconds.
    pub latency_s: f64,
    /// What comes on top of it by chance, seconds.
    #[serde(default)]
    pub latency_jitter_s: f64,
    /// Pictures that are lost or frozen; left out: none.
    pub loss: Option<LossSection>,
    /// How far the first view points past the target on average, pan and tilt, radians.
    #[serde(default)]
    pub first_view_rad: [f64; 2],
    /// Deviation of that from trial to trial.
    pub first_view_deviation_rad: [f64; 2],
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisSection {
    /// From a command that moves to what is seen of it, seconds: the camera's latency is part of it.
    pub start_dead_time_s: f64,
    /// From a zero to what is seen of it, likewise.
    pub stop_dead_time_s: f64,
    /// Time constant, seconds.
    pub lag_s: f64,
    /// Largest rate, rad/s.
    pub limit_rad_per_s: f64,
    /// End stops, degrees; left out: none.
    pub stops_deg: Option<[f64; 2]>,
    /// Largest change of the rate, rad/s²; left out: the lag alone limits it.
    pub acceleration_rad_per_s2: Option<f64>,
    /// A rate below this moves nothing, rad/s.
    #[serde(default)]
    pub dead_band_rad_per_s: f64,
}

/// Pictures that are lost or frozen.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LossSection {
    /// Chance from picture to picture that the link becomes bad.
    pub to_bad: f64,
    /// And good again.
    pub to_good: f64,
    /// Share of the pictures that a bad link spoils.
    pub spoilt: f64,
    /// Share of those that show the picture before; the others do not come.
    pub frozen: f64,
}

/// A kite on its line.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KiteSection {
    /// How often gusts come and how strong they are: 1 as usual.
    pub gustiness: f64,
}

/// The water and the wind over it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaterSection {
    /// 0 (glassy) to 4 (moderate).
    pub sea_state: u8,
    /// Mean wind, m/s; left out: what raises such a sea.
    pub wind_m_per_s: Option<f64>,
    /// Where it blows to: 0 along x, anticlockwise.
    pub wind_towards_deg: f64,
}

/// The light.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightSection {
    /// Where the sun stands: 0 ahead of the first view, positive to the right.
    pub sun_bearing_deg: f64,
    /// Its height above the horizon.
    pub sun_elevation_deg: f64,
    /// 0 (clear) to 1 (overcast).
    pub overcast: f64,
}

/// A boat that is driven along a path.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoatSection {
    /// A built-in path.
    pub path: Option<String>,
    /// Or way-points, metres.
    pub way_points: Option<Vec<[f64; 2]>>,
    /// By what the path is stretched.
    pub scale: f64,
    /// Median speed of the trials, m/s.
    pub speed_m_per_s: f64,
    /// Deviation of its logarithm.
    pub speed_spread: f64,
    /// Largest throttle, 0 to 1.
    pub most_throttle: f64,
    /// How far ahead on the path it aims, metres.
    pub look_ahead_m: f64,
    /// Deviation of each way-point, metres.
    pub way_point_jitter_m: f64,
}

/// A thing beside the target.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneObjectSection {
    /// What it is.
    pub kind: SceneObjectName,
    /// Where, metres.
    pub at: [f64; 2],
    /// Deviation of that from trial to trial, metres.
    #[serde(default)]
    pub jitter_m: f64,
    /// How it lies: 0 along x, anticlockwise.
    #[serde(default)]
    pub heading_deg: f64,
    /// Its velocity along x and y, m/s.
    #[serde(default)]
    pub velocity_m_per_s: [f64; 2],
    /// It goes to and fro and turns round after so many seconds.
    pub turns_after_s: Option<f64>,
    /// Of a pier: length and breadth, metres.
    pub size_m: Option<[f64; 2]>,
}

/// What there may be beside the target.
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

/// Intervals of what is drawn.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampledSection {
    /// Focal length, pixels.
    pub focal_px: [f64; 2],
    /// Pan.
    pub pan: SampledAxisSection,
    /// Tilt.
    pub tilt: SampledAxisSection,
    /// Share of each axis's rate that turns the other one too; left out: the nominal one.
    pub cross_talk: Option<[f64; 2]>,
    /// How fast the tilt sinks, degrees per second; left out: the nominal one.
    pub droop_deg_per_s: Option<[f64; 2]>,
}

/// Intervals of what is drawn of an axis, seconds.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampledAxisSection {
    /// As in the axis.
    pub start_dead_time_s: [f64; 2],
    /// As in the axis.
    pub stop_dead_time_s: [f64; 2],
    /// As in the axis.
    pub lag_s: [f64; 2],
    /// What share of the rate asked for it turns at; left out: 1.
    pub gain: Option<[f64; 2]>,
}

/// How the kite sways: deviations, and the times after which they are forgotten.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SwaySection {
    /// Degrees.
    pub yaw_deg: f64,
    /// Seconds.
    pub yaw_time_s: f64,
    /// Degrees.
    pub pitch_deg: f64,
    /// Seconds.
    pub pitch_time_s: f64,
    /// Degrees.
    pub roll_deg: f64,
    /// Seconds.
    pub roll_time_s: f64,
    /// Metres, in each coordinate.
    pub place_m: f64,
    /// Seconds.
    pub place_time_s: f64,
}

/// The target.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetSection {
    /// A built-in path.
    pub path: Option<String>,
    /// Or way-points, metres.
    pub way_points: Option<Vec<[f64; 2]>>,
    /// A way-point before the first of the path; left out: it begins with that.
    pub start_m: Option<[f64; 2]>,
    /// By what the path is stretched.
    pub scale: f64,
    /// By what it is stretched across in addition; left out: not at all.
    pub breadth: Option<f64>,
    /// Median speed of the trials, m/s.
    pub speed_m_per_s: f64,
    /// Deviation of the logarithm of the trials' speeds.
    pub speed_spread: f64,
    /// Deviation of the logarithm of the speed during a trial.
    pub gust_share: f64,
    /// Time after which that is forgotten, seconds.
    pub gust_time_s: f64,
    /// Deviation by which its heading weaves, radians.
    #[serde(default)]
    pub weave_rad: f64,
    /// Time after which that is forgotten, seconds.
    #[serde(default = "one_second")]
    pub weave_time_s: f64,
    /// How far ahead on the path it looks, metres.
    pub look_ahead_m: f64,
    /// Deviation of each way-point, metres.
    pub way_point_jitter_m: f64,
    /// Turn rate for each radian that it points off, 1/s.
    pub heading_gain: f64,
    /// Largest turn rate, rad/s.
    pub most_turn_rad_per_s: f64,
    /// Time constant of its speed, seconds.
    pub surge_lag_s: f64,
    /// Time constant of its turn rate, seconds.
    pub turn_lag_s: f64,
    /// Share of its speed that it gives up at a right angle.
    pub corner_slow_down: f64,
    /// Over so many of the path's last metres it comes to rest.
    #[serde(default)]
    pub arrival_m: f64,
    /// Mean time that it stands before it starts, seconds.
    pub stand_before_s: f64,
    /// Mean time that it stands at the end, seconds.
    pub stand_after_s: f64,
    /// Pauses for each second under way.
    pub pauses_per_s: f64,
    /// At what share of the path's corners it pauses in addition, 0 to 1.
    #[serde(default)]
    pub corner_pauses: f64,
    /// What share of its speed it gives up at the ends of each leg from corner to corner, 0 to 1.
    #[serde(default)]
    pub leg_rhythm: f64,
    /// By which power of its distance from below the camera its speed grows, 0 to 1.
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
    /// Deviation, pixels.
    pub noise_px: f64,
    /// After what time it is another, seconds; 0: with each picture.
    #[serde(default)]
    pub noise_time_s: f64,
    /// Whole pixels.
    pub rounded: bool,
    /// A target out of the picture is said to be at its border: largest |x| and |y|, pixels; left out: it is lost.
    pub clamped_at_px: Option<[f64; 2]>,
}

/// A path's file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathFile {
    /// Way-points, metres.
    pub way_points: Vec<[f64; 2]>,
}

const fn one_second() -> f64 {
    1.0
}
