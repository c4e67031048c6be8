//! What a gimbal manager says of a gimbal.

use super::command::Gimbal;

/// What a gimbal manager says of its gimbal: axes and end stops. Angles are radians, pitch above the horizon
/// and yaw to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Information {
    /// The gimbal.
    pub gimbal: Gimbal,
    /// Whether it pitches.
    pub has_pitch: bool,
    /// Whether it yaws.
    pub has_yaw: bool,
    /// Whether it rolls.
    pub has_roll: bool,
    /// Least and largest pitch; `None`: not stated.
    pub pitch_stops: Option<(f64, f64)>,
    /// Least and largest yaw; `None`: not stated, or without end.
    pub yaw_stops: Option<(f64, f64)>,
}

impl Information {
    /// Whether any axis is named.
    pub const fn has_axes(&self) -> bool {
        self.has_pitch || self.has_yaw || self.has_roll
    }

    /// Whether the gimbal has both axes that are moved.
    pub const fn can_pan_and_tilt(&self) -> bool {
        self.has_pitch && self.has_yaw
    }
}
