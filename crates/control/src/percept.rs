//! The percept: the target's position relative to the region.

use barrelman_vocab::{Angle, ImagePoint};

use crate::region::Region;

/// The target's position relative to the region, as a law uses it.
///
/// ```
/// use barrelman_control::{Percept, Region};
/// use barrelman_vocab::ImagePoint;
///
/// let region = Region { a_px: 200.0, b_px: 100.0 };
/// let percept = Percept::new(ImagePoint { x: 0.0, y: 200.0 }, region);
/// assert_eq!((percept.p, percept.r_px), (4.0, 200.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percept {
    /// Position of the target in image coordinates.
    pub position: ImagePoint,
    /// P of the position (`biswas2017`, equation 1): at most 1 inside the region, more than 1 outside.
    pub p: f64,
    /// Distance from the picture's centre, pixels.
    pub r_px: f64,
    /// Direction from the picture's centre, anticlockwise from image right, in (-pi, pi].
    pub direction: Angle,
}

impl Percept {
    /// The percept of a target at `position`.
    pub fn new(position: ImagePoint, region: Region) -> Self {
        Self {
            position,
            p: region.p(position),
            r_px: libm::hypot(position.x, position.y),
            direction: Angle::from_radians(libm::atan2(position.y, position.x)),
        }
    }
}
