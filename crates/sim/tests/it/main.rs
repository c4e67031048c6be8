//! Integration tests of the simulated world.

mod boat;
mod camera_axis;
mod kite;
mod path;
mod practice;
mod render;
mod sea;
mod trial_world;
mod video_link;
mod world;
