//! Points on the water, and where the camera is above the water.
//!
//! The *water frame* is a right-handed frame of reference at rest: x to the right and y ahead of pan 0,
//! metres, on the plane of the water at rest. The origin is a fixed point, by default the point below the
//! camera. Courses and headings on the water are 0 along y (ahead) and grow to the right (clockwise as seen
//! from above), as pan does.

use crate::angle::Angle;

/// A point on the water.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WaterPoint {
    /// To the right of pan 0, metres.
    pub x: f64,
    /// Ahead at pan 0, metres.
    pub y: f64,
}

impl WaterPoint {
    /// The vector from this point to another, metres.
    pub const fn vector_to(self, other: Self) -> (f64, f64) {
        (other.x - self.x, other.y - self.y)
    }

    /// Distance to another point, metres.
    pub fn distance_to(self, other: Self) -> f64 {
        let (x, y) = self.vector_to(other);
        libm::sqrt(x * x + y * y)
    }

    /// Bearing of another point from this point: 0 ahead, positive to the right.
    pub fn bearing_to(self, other: Self) -> Angle {
        let (x, y) = self.vector_to(other);
        Angle::from_radians(libm::atan2(x, y))
    }
}

/// Covariance of a point on the water, m².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WaterCovariance {
    /// Variance of x.
    pub xx: f64,
    /// Covariance of x and y.
    pub xy: f64,
    /// Variance of y.
    pub yy: f64,
}

impl WaterCovariance {
    /// Equal in all directions; the standard deviation is in metres.
    pub const fn isotropic(std_dev_m: f64) -> Self {
        let variance = std_dev_m * std_dev_m;
        Self { xx: variance, xy: 0.0, yy: variance }
    }

    /// The largest standard deviation over all directions, metres.
    pub fn max_std_dev_m(self) -> f64 {
        let half = 0.5 * (self.xx - self.yy);
        libm::sqrt(0.5 * (self.xx + self.yy) + libm::sqrt(half * half + self.xy * self.xy))
    }
}

/// A point on the water with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaterFix {
    /// The point.
    pub point: WaterPoint,
    /// Its uncertainty.
    pub covariance: WaterCovariance,
}

/// Position and attitude of a camera above the water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraAboveWater {
    /// The point of the water below the optical centre.
    pub below: WaterPoint,
    /// Height of the optical centre above the water at rest, metres, above 0.
    pub height_m: f64,
    /// Positive to the right.
    pub pan: Angle,
    /// 0 level, positive upwards.
    pub tilt: Angle,
    /// About the line of sight; positive where the camera's right side sinks.
    pub roll: Angle,
}

/// Standard deviations of what a point on the water is computed from. Errors of height and attitude are
/// common to all points of one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightingNoise {
    /// Of each pixel coordinate, pixels.
    pub pixel_px: f64,
    /// Of the height, metres.
    pub height_m: f64,
    /// Of the pan.
    pub pan: Angle,
    /// Of the tilt.
    pub tilt: Angle,
    /// Of the roll.
    pub roll: Angle,
}

/// What is seen at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sighting {
    /// A point on the water.
    OnWater(WaterPoint),
    /// The line of sight is above the horizon, or so little below it that the distance is unknown.
    AtHorizon {
        /// Angle of the line of sight below the horizon; negative above it.
        depression: Angle,
    },
    /// The lens maps no line of sight to this pixel.
    OutsideLens,
}

impl Sighting {
    /// The point on the water, if there is one.
    pub const fn point(self) -> Option<WaterPoint> {
        match self {
            Self::OnWater(point) => Some(point),
            Self::AtHorizon { .. } | Self::OutsideLens => None,
        }
    }
}
