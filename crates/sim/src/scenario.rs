//! A scenario: all parameters of a trial except its seed.
//!
//! Plain values; they are checked where they are read from a file, and nothing here knows the file format.
//! Lengths are metres, times seconds, angles radians, positions those of the world ([`crate::pose`]).

use core::time::Duration;

use barrelman_vocab::{Angle, PictureSize};

use crate::camera_axis::AxisPlant;
use crate::camera_mount::MountPlant;
use crate::electronics::ElectronicsModel;
use crate::helmsman::BoatScript;
use crate::optics::Optics;
use crate::pursuit::PursuitScript;
use crate::random::{CounterRng, OrnsteinUhlenbeck, Stream};
use crate::scenery::ObjectScript;
use crate::sea::{SeaState, Wind};
use crate::snapshot::Light;
use crate::sway::Sway;
use crate::tick::TICKS_PER_SECOND;
use crate::video_link::VideoLinkModel;
use crate::zoom::Zoom;

/// All parameters of a trial except its seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Name of the scenario.
    pub name: String,
    /// Position, optics and video of the camera.
    pub camera: CameraSetup,
    /// Nominal dynamics of the camera's axes.
    pub mount: MountPlant,
    /// Ranges from which the plant is sampled for each trial, where that is asked for.
    pub ranges: PlantRanges,
    /// What carries the camera.
    pub platform: Platform,
    /// The water; `None` for the laboratory's floor.
    pub water: Option<Water>,
    /// Sun and sky.
    pub light: Light,
    /// The target.
    pub target: TargetScript,
    /// Objects beside the target.
    pub objects: Vec<ObjectScript>,
    /// Model of localisations without pixels.
    pub sensing: SensorModel,
    /// Longest duration of a trial, seconds.
    pub max_s: f64,
}

/// The camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraSetup {
    /// Height of the optical centre above floor or water, metres.
    pub height_m: f64,
    /// Lens and picture size.
    pub optics: Optics,
    /// Size of the frame with the picture at its centre; larger than the picture where the video is
    /// letter-boxed.
    pub frame: PictureSize,
    /// Frame rate; a divisor of the ticks per second.
    pub pictures_per_second: u32,
    /// From the exposure of the first row to that of the last, seconds.
    pub rolling_shutter_s: f64,
    /// Delays and losses of the video.
    pub video: VideoLinkModel,
    /// Offset of the first view from the target.
    pub first_view: FirstView,
    /// Drift of the camera's electronics.
    pub electronics: ElectronicsModel,
    /// How the camera zooms by itself; `None`: it does not.
    pub zoom: Option<Zoom>,
}

/// Offset of the first view from the target: pan and tilt, radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FirstView {
    /// Mean over the trials.
    pub mean: (f64, f64),
    /// Standard deviation over the trials.
    pub std_dev: (f64, f64),
}

/// What carries the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Platform {
    /// A platform whose angles and position are independent random processes.
    Swaying(Sway),
    /// A kite on its tether, in the wind.
    Kite {
        /// Factor of the rate and the strength of gusts; nominally 1.
        gustiness: f64,
    },
}

/// The water and the wind over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    /// Sea state.
    pub state: SeaState,
    /// Wind 10 m above the water.
    pub wind: Wind,
    /// Steady current along the world's x and y, m/s.
    pub current_m_per_s: (f64, f64),
}

/// Ranges of the plant's parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantRanges {
    /// Focal length, pixels.
    pub focal_px: (f64, f64),
    /// Pan.
    pub pan: AxisRanges,
    /// Tilt.
    pub tilt: AxisRanges,
    /// Cross-talk between the axes.
    pub cross_talk: (f64, f64),
    /// Droop of the tilt, rad/s.
    pub droop_rad_per_s: (f64, f64),
}

/// Ranges of an axis's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisRanges {
    /// Dead time before a start, seconds.
    pub start_dead_time_s: (f64, f64),
    /// Dead time before a stop, seconds.
    pub stop_dead_time_s: (f64, f64),
    /// Lag, seconds.
    pub lag_s: (f64, f64),
    /// Achieved share of the commanded rate.
    pub gain: (f64, f64),
}

/// The target.
#[derive(Debug, Clone, PartialEq)]
pub enum TargetScript {
    /// A target that moves along a path regardless of floor or water.
    Pursuit(PursuitScript),
    /// A boat that is driven along a path.
    Boat(BoatScript),
}

/// Model of localisations without pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorModel {
    /// Error of each coordinate, pixels.
    pub noise: OrnsteinUhlenbeck,
    /// Whether coordinates are rounded to whole pixels.
    pub is_rounded: bool,
    /// What is reported of a target outside the picture.
    pub beyond_border: BeyondBorder,
    /// Length and breadth of the target, metres.
    pub target_size_m: (f64, f64),
    /// Standard deviation of the bow's direction in the picture; `None`: the direction is not measured.
    pub heading_std_dev: Option<Angle>,
}

/// What is reported of a target outside the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BeyondBorder {
    /// Each image coordinate is clamped, as by the tracker of the recorded trials.
    Clamped {
        /// Largest |x|.
        x_px: f64,
        /// Largest |y|.
        y_px: f64,
    },
    /// Nothing: the track is lost.
    Absent,
}

impl Scenario {
    /// The same scenario with a plant sampled uniformly from its ranges.
    #[must_use]
    pub fn with_sampled_plant(&self, seed: u64) -> Self {
        let rng = CounterRng::new(seed, Stream::Plant);
        let mut sampled = self.clone();
        sampled.camera.optics.focal_px = rng.between(0, self.ranges.focal_px);
        let axis = |nominal: &AxisPlant, ranges: &AxisRanges, first: u64| {
            let mut axis = *nominal;
            axis.start_dead_time_s = rng.between(first, ranges.start_dead_time_s);
            axis.stop_dead_time_s = rng.between(first + 1, ranges.stop_dead_time_s);
            axis.lag_s = rng.between(first + 2, ranges.lag_s);
            axis.imperfections.gain = rng.between(first + 3, ranges.gain);
            axis
        };
        sampled.mount = MountPlant {
            pan: axis(&self.mount.pan, &self.ranges.pan, 1),
            tilt: axis(&self.mount.tilt, &self.ranges.tilt, 5),
            cross_talk: rng.between(9, self.ranges.cross_talk),
            droop_rad_per_s: rng.between(10, self.ranges.droop_rad_per_s),
            zoom: self.mount.zoom,
        };
        sampled
    }
}

impl CameraSetup {
    /// Ticks from one video frame to the next.
    pub const fn ticks_per_picture(&self) -> u64 {
        (TICKS_PER_SECOND / self.pictures_per_second) as u64
    }

    /// Least latency of the video.
    pub fn latency(&self) -> Duration {
        Duration::from_secs_f64(self.video.latency_s)
    }
}

impl FirstView {
    /// Offset of a trial's first view: pan and tilt.
    pub(crate) fn sampled_offset(&self, seed: u64) -> (Angle, Angle) {
        let rng = CounterRng::new(seed, Stream::FirstView);
        let off = |mean: f64, std_dev: f64, index| Angle::from_radians(mean + std_dev * rng.normal(index));
        (off(self.mean.0, self.std_dev.0, 0), off(self.mean.1, self.std_dev.1, 1))
    }
}
