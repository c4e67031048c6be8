//! A scenario: everything that a trial is made of, but its seed.
//!
//! Plain values, checked where they are read from a file; nothing here knows the file. Lengths are metres, times
//! seconds, angles radians, places those of the world ([`crate::pose`]).

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

/// Everything that a trial is made of, but its seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// What it is called.
    pub name: String,
    /// The camera: where it hangs and what it sees.
    pub camera: CameraSetup,
    /// How its axes turn.
    pub mount: MountPlant,
    /// What of it is drawn anew for each trial, where that is asked for.
    pub ranges: PlantRanges,
    /// What the camera hangs on.
    pub platform: Platform,
    /// The water; `None`: the laboratory's floor.
    pub water: Option<Water>,
    /// The light.
    pub light: Light,
    /// The target.
    pub target: TargetScript,
    /// What else there is.
    pub objects: Vec<ObjectScript>,
    /// What a localisation without pixels is like.
    pub sensing: SensorModel,
    /// No trial lasts longer than this, seconds.
    pub max_s: f64,
}

/// The camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraSetup {
    /// Height of its optical centre above floor or water, metres.
    pub height_m: f64,
    /// Its lens and picture.
    pub optics: Optics,
    /// The frame that the picture lies in the middle of: larger than the picture where it is letter-boxed.
    pub frame: PictureSize,
    /// Pictures per second: a divisor of the ticks per second.
    pub pictures_per_second: u32,
    /// From its first row to its last, seconds.
    pub rolling_shutter_s: f64,
    /// How the pictures come to the pilot.
    pub video: VideoLinkModel,
    /// How far the first view points past the target.
    pub first_view: FirstView,
    /// How its electronics drift.
    pub electronics: ElectronicsModel,
}

/// How far the first view points past the target, pan and tilt, radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FirstView {
    /// Mean over the trials.
    pub mean: (f64, f64),
    /// Standard deviation.
    pub std_dev: (f64, f64),
}

/// What the camera hangs on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Platform {
    /// Something whose angles and place wander, each by itself.
    Swaying(Sway),
    /// A kite on its line, in the wind.
    Kite {
        /// How often gusts come and how strong they are: 1 as usual.
        gustiness: f64,
    },
}

/// The water and the wind over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    /// How rough it is.
    pub state: SeaState,
    /// The wind, 10 m above it.
    pub wind: Wind,
}

/// Intervals in which the plant lies.
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

/// Intervals in which an axis lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisRanges {
    /// Dead time before a start, seconds.
    pub start_dead_time_s: (f64, f64),
    /// Dead time before a stop, seconds.
    pub stop_dead_time_s: (f64, f64),
    /// Lag, seconds.
    pub lag_s: (f64, f64),
    /// What share of the rate asked for it turns at.
    pub gain: (f64, f64),
}

/// The target.
#[derive(Debug, Clone, PartialEq)]
pub enum TargetScript {
    /// Moved along a path whatever floor or water do.
    Pursuit(PursuitScript),
    /// A boat that is driven along a path.
    Boat(BoatScript),
}

/// What a localisation without pixels is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorModel {
    /// How far each coordinate is off, pixels.
    pub noise: OrnsteinUhlenbeck,
    /// Whether coordinates are whole pixels.
    pub is_rounded: bool,
    /// What is said of a target that is out of the picture.
    pub beyond_border: BeyondBorder,
    /// Length and breadth of the target, metres.
    pub target_size_m: (f64, f64),
}

/// What is said of a target that is out of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BeyondBorder {
    /// That it is at the border: each image coordinate is clamped to these, pixels. So did the tracker of the
    /// recorded trials.
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
    /// The same scenario with a plant drawn for a trial from its ranges, each value evenly over its interval.
    #[must_use]
    pub fn with_sampled_plant(&self, seed: u64) -> Self {
        let rng = CounterRng::new(seed, Stream::Plant);
        let mut drawn = self.clone();
        drawn.camera.optics.focal_px = rng.between(0, self.ranges.focal_px);
        let axis = |nominal: &AxisPlant, ranges: &AxisRanges, first: u64| {
            let mut axis = *nominal;
            axis.start_dead_time_s = rng.between(first, ranges.start_dead_time_s);
            axis.stop_dead_time_s = rng.between(first + 1, ranges.stop_dead_time_s);
            axis.lag_s = rng.between(first + 2, ranges.lag_s);
            axis.imperfections.gain = rng.between(first + 3, ranges.gain);
            axis
        };
        drawn.mount = MountPlant {
            pan: axis(&self.mount.pan, &self.ranges.pan, 1),
            tilt: axis(&self.mount.tilt, &self.ranges.tilt, 5),
            cross_talk: rng.between(9, self.ranges.cross_talk),
            droop_rad_per_s: rng.between(10, self.ranges.droop_rad_per_s),
        };
        drawn
    }
}

impl CameraSetup {
    /// Ticks from one picture to the next.
    pub const fn ticks_per_picture(&self) -> u64 {
        (TICKS_PER_SECOND / self.pictures_per_second) as u64
    }

    /// What a picture takes to the pilot at least.
    pub fn latency(&self) -> Duration {
        Duration::from_secs_f64(self.video.latency_s)
    }
}

impl FirstView {
    /// By what the first view of a trial is off: pan and tilt.
    pub(crate) fn sampled_offset(&self, seed: u64) -> (Angle, Angle) {
        let rng = CounterRng::new(seed, Stream::FirstView);
        let off = |mean: f64, std_dev: f64, index| Angle::from_radians(mean + std_dev * rng.normal(index));
        (off(self.mean.0, self.std_dev.0, 0), off(self.mean.1, self.std_dev.1, 1))
    }
}
