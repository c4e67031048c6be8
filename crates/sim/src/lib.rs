//! A world to servo in: so far the camera's axes of a kite, and a practice clip of a boat on water.
//!
//! What must not be here: clocks, threads, files, the tracker, and any chance that does not come from a seed.
//! The same seed gives the same bits on every machine: transcendental functions come from `libm`, noise from
//! integer hashes.
#![forbid(unsafe_code)]

pub mod camera_axis;
pub mod camera_mount;

pub mod noise;
pub mod practice;

pub use camera_axis::{AxisPlant, CameraAxis};
pub use camera_mount::{CameraMount, MountPlant};
