//! `geometry_msgs`.

use serde::Serialize;

use super::Header;

/// `geometry_msgs/Vector3`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Vector3 {
    /// Along or about x.
    pub x: f64,
    /// Along or about y.
    pub y: f64,
    /// Along or about z.
    pub z: f64,
}

/// `geometry_msgs/Twist`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Twist {
    /// Velocity, m/s.
    pub linear: Vector3,
    /// Angular velocity, rad/s.
    pub angular: Vector3,
}

/// `geometry_msgs/TwistStamped`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct TwistStamped {
    /// Time and frame of reference.
    pub header: Header,
    /// The velocities.
    pub twist: Twist,
}

/// `geometry_msgs/Point`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Point {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Metres.
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quaternion {
    /// First component.
    pub x: f64,
    /// Second component.
    pub y: f64,
    /// Third component.
    pub z: f64,
    /// Real component.
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `geometry_msgs/Pose`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Pose {
    /// The place.
    pub position: Point,
    /// The attitude.
    pub orientation: Quaternion,
}

/// The covariance of a pose, six by six, row by row.
type PoseCovariance = [[f64; 18]; 2];

/// `geometry_msgs/PoseWithCovariance`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// The covariance. (In two halves: serde knows arrays of up to 32 elements.)
    pub covariance: PoseCovariance,
}
