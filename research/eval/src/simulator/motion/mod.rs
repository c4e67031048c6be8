//! How a target moved, without the camera's motion: the statistics that the simulated target is fitted to.
//!
//! The camera's angles are reconstructed from the commands with the identified plant (dead times, lag), so
//! that each position in the picture becomes a direction in the room: azimuth and depression ([`bearings`]).
//! The target's velocity is the change of that direction over half a second times the focal length, pixels
//! per second ([`velocities`]). The region and P are not used, and recorded and simulated trials are treated
//! alike.

mod bearings;
mod direction_changes;
mod displacements;
mod legs;
mod pauses;
mod statistics;
mod summary;
mod target_motion;
mod velocities;

pub(super) use statistics::{Group, MotionStatistics, STATISTICS};
pub(super) use target_motion::{MovingSample, moving_samples};
