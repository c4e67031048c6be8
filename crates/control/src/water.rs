//! Pixels, lines of sight and points on the water.
//!
//! [`lens`] maps pixel coordinates to the tangents of a line of sight and back; [`WaterView`] turns lines of
//! sight by the camera's attitude and intersects them with the plane of the water at rest. [`earth`] places
//! points on the water on Earth.
//!
//! Not handled: waves (a crest of height h shifts a point by h / tan(depression)), the curvature of the Earth
//! (at 300 m less than a centimetre), refraction, the rolling shutter.

pub mod earth;
pub mod lens;
pub mod lens_fault;

mod view;

pub use view::{MIN_DEPRESSION, WaterView};
