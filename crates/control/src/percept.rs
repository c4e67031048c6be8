//! What a localisation means to a camera law.

use barrelman_vocab::{Angle, ImagePoint};

use crate::region::Region;

/// The target as a law sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percept {
    /// Where the target is, in image coordinates.
    pub position: ImagePoint,
    /// P of that position in the region (`biswas2017`, equation 1): more than 1 is outside.
    pub p: f64,
    /// Distance from the picture's centre, pixels.
    pub r_px: f64,
    /// Direction from the picture's centre, anticlockwise from image right, -pi (exclusive) to pi (inclusive).
    pub direction: Angle,
}

impl Percept {
    /// The percept of a target at `position` for a region.
    pub fn new(position: ImagePoint, region: Region) -> Self {
        Self {
            position,
            p: region.p(position),
            r_px: libm::hypot(position.x, position.y),
            direction: Angle::from_radians(libm::atan2(position.y, position.x)),
        }
    }
}
