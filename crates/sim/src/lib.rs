//! A simulated world to servo in: the camera's axes on a swaying or flying platform, a target on water or on
//! a floor, a renderer, a practice clip, and test scenes for a tracker.
//!
//! What must not be here: clocks, threads, files, the tracker, and any randomness that does not come from a
//! seed. The same seed gives the same bits on every machine: transcendental functions come from `libm`,
//! random numbers from integer hashes.
#![deny(unsafe_code)]

pub mod optics;
pub mod pose;
pub mod snapshot;

pub mod scenario;

pub mod world;

pub mod render;
pub mod sea;

pub mod tick;

pub mod camera_axis;
pub mod camera_mount;
pub mod kite;
pub mod path;
pub mod pursuit;
pub mod sway;
pub mod zoom;

pub mod boat;
pub mod helmsman;
pub mod wind;

pub mod scenery;

pub mod electronics;
pub mod sensor;
pub mod video_link;

pub mod noise;
pub mod random;

pub mod practice;

pub use camera_axis::{AxisPlant, CameraAxis};
pub use camera_mount::{CameraMount, MountPlant};
pub use optics::Optics;
pub use pose::{BodyPose, CameraPose, WorldPoint};
pub use scenario::Scenario;
pub use sea::{Sea, SeaState, Wind};
pub use sensor::LocalisationSensor;
pub use snapshot::Snapshot;
pub use world::{Truth, World};
