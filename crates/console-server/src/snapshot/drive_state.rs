//! A simulated world, and the boat and the time of a demo.

use schemars::JsonSchema;
use serde::Serialize;

/// A simulated world.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct WorldState {
    /// The scenario.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// True bounds of the boat in the newest picture, pixels: left, top, width, height. In a demo only, and
    /// only until something is selected.
    pub boat: Option<[f64; 4]>,
}

/// The state of a demo.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DriveState {
    /// Ticks since the drive's start, 120 a second.
    pub tick: u64,
    /// Time since the drive's start, seconds.
    pub time_s: f64,
    /// Whether the time of the world stands still.
    pub paused: bool,
    /// Whether it stands still until the first selection (`demo --hands-on`).
    pub waits: bool,
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
