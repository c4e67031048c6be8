//! From the console's API to ROS 2 messages. No socket, no clock.

pub mod camera_rate;
pub mod detections;
pub mod diagnostics;
pub mod fixes;
pub mod frames;
pub mod picture;
