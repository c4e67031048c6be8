//! The water surface around an object, as a plane that cuts the object.

use crate::pose::WorldPoint;

/// Below this height above the water, small waves decide where an object is cut, metres.
pub(super) const MAX_RIPPLED_M: f32 = 0.03;
/// Upper bound of the height of the small waves, metres.
pub(super) const MAX_RIPPLE_M: f32 = 0.01;

/// The water around an object, as a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waterline {
    /// A point of the plane.
    pub(super) position: WorldPoint,
    /// Slope of the plane along the world's x and y.
    pub(super) slope: (f64, f64),
}

impl Waterline {
    /// Height of a point above the water, metres.
    pub(super) fn height_above(&self, p: [f32; 3]) -> f32 {
        let (dx, dy) = (p[0] - self.position.x as f32, p[1] - self.position.y as f32);
        p[2] - (self.position.z as f32 + self.slope.0 as f32 * dx + self.slope.1 as f32 * dy)
    }
}

/// Elevation of the small waves along a waterline at a point of the world, metres: no hull is cut along a
/// straight line.
pub(super) fn ripple_elevation(world: [f32; 3]) -> f32 {
    let wave = |x: f32| {
        let x = x - libm::floorf(x);
        (x - x * x) * 4.0
    };
    0.008 * (wave(world[0] * 3.1 + world[1] * 1.3) + wave(world[1] * 4.3 - world[0] * 1.7) - 1.2)
}
