//! The simulated world, by tables.

mod camera_axis;
mod practice;
