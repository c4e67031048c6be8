//! The simulated boat and world of a demo.

use schemars::JsonSchema;
use serde::Serialize;

/// The state of the simulated world.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DriveState {
    /// The scenario.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// Ticks since the drive's start, 120 a second.
    pub tick: u64,
    /// Time since the drive's start, seconds.
    pub time_s: f64,
    /// Whether the drive is paused.
    pub paused: bool,
    /// Simulated seconds per second.
    pub pace: f64,
    /// The camera's actual pan and tilt rates, rad/s.
    pub achieved: [f64; 2],
    /// The boat's speed ahead, m/s.
    pub speed_m_per_s: f64,
    /// Who steers: `page`, `helmsman`, or `nobody` where the target cannot be steered.
    pub helm: &'static str,
    /// Whether the boat is in the newest picture.
    pub in_picture: Option<bool>,
}
