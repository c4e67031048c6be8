//! A world to servo in: the camera's axes of a kite, a practice clip of a boat on water, and test scenes for
//! a tracker.
//!
//! What must not be here: clocks, threads, files, the tracker, and any chance that does not come from a seed.
//! The same seed gives the same bits on every machine: transcendental functions come from `libm`, noise from
//! integer hashes.
#![forbid(unsafe_code)]

pub mod camera_axis;
pub mod camera_mount;

pub mod noise;
pub mod practice;
pub mod water_scene;

pub use camera_axis::{AxisPlant, CameraAxis};
pub use camera_mount::{CameraMount, MountPlant};
pub use water_scene::{SceneKind, SceneScript, SceneTruth, TargetPaint, WaterScene};
