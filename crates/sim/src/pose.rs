//! Positions and attitudes in the world.
//!
//! The *world* is a right-handed frame of reference at rest: x to the right and y ahead of the camera's first
//! view, z up, metres; z = 0 is the floor, or the water at rest. *Headings* of bodies are 0 along x and grow
//! anticlockwise as seen from above. *Camera angles* are those of the whole program: pan is 0 along y and
//! grows to the right (clockwise as seen from above), tilt is 0 at level and grows upwards.

use barrelman_vocab::Angle;

/// A point of the world, or the difference of two points, metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WorldPoint {
    /// To the right of the first view.
    pub x: f64,
    /// Ahead of the first view.
    pub y: f64,
    /// Up.
    pub z: f64,
}

impl WorldPoint {
    /// The vector from this point to another.
    pub fn vector_to(self, other: Self) -> Self {
        Self { x: other.x - self.x, y: other.y - self.y, z: other.z - self.z }
    }

    /// Scalar product.
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Euclidean norm, metres.
    pub fn norm(self) -> f64 {
        libm::sqrt(self.dot(self))
    }
}

/// Position and attitude of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Optical centre.
    pub position: WorldPoint,
    /// 0 along the world's y, positive to the right.
    pub pan: Angle,
    /// 0 level, positive upwards.
    pub tilt: Angle,
    /// About the line of sight; positive where the camera's right side sinks, so that the horizon climbs to
    /// the right in the picture.
    pub roll: Angle,
}

/// Axes of the camera: unit vectors in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraAxes {
    /// Right in the picture.
    pub right: WorldPoint,
    /// Down in the picture.
    pub down: WorldPoint,
    /// Along the line of sight.
    pub ahead: WorldPoint,
}

impl CameraPose {
    /// The axes of the camera.
    pub fn axes(&self) -> CameraAxes {
        let (sp, cp) = (libm::sin(self.pan.radians()), libm::cos(self.pan.radians()));
        let (st, ct) = (libm::sin(self.tilt.radians()), libm::cos(self.tilt.radians()));
        let (sr, cr) = (libm::sin(self.roll.radians()), libm::cos(self.roll.radians()));
        let ahead = WorldPoint { x: sp * ct, y: cp * ct, z: st };
        let level = WorldPoint { x: cp, y: -sp, z: 0.0 };
        let under = WorldPoint { x: sp * st, y: cp * st, z: -ct };
        let mix = |a: f64, b: f64| WorldPoint {
            x: a * level.x + b * under.x,
            y: a * level.y + b * under.y,
            z: a * level.z + b * under.z,
        };
        CameraAxes { right: mix(cr, sr), down: mix(-sr, cr), ahead }
    }

    /// A point of the world in the camera's frame of reference: right, down and ahead of the optical centre,
    /// metres.
    pub fn camera_from_world(&self, position: WorldPoint) -> (f64, f64, f64) {
        let axes = self.axes();
        let from_camera = self.position.vector_to(position);
        (from_camera.dot(axes.right), from_camera.dot(axes.down), from_camera.dot(axes.ahead))
    }
}

/// Position and attitude of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPose {
    /// Origin of the body: for a boat, the middle of its waterline.
    pub position: WorldPoint,
    /// Direction of the bow: 0 along the world's x, anticlockwise as seen from above.
    pub heading: Angle,
    /// Positive where the bow rises.
    pub pitch: Angle,
    /// Positive where the right side sinks.
    pub roll: Angle,
}
