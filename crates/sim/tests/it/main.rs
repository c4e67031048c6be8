//! The simulated world, by tables.

mod camera_axis;
mod practice;
mod water_scene;
