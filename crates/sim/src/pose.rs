//! Places and attitudes in the world.
//!
//! The *world* is a right-handed frame of reference that does not move: x to the right and y ahead of where the camera
//! hangs, z up, metres; z = 0 is the floor, or the water at rest. *Headings* of bodies grow
//! anticlockwise as seen from above and are 0 along x. The *camera's* angles are those of the whole program: pan
//! is 0 along y and grows to the right (clockwise as seen from above), tilt is 0 at level and grows upwards.

use barrelman_vocab::Angle;

/// A place in the world, or a difference of two, metres.
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
    /// From one place to another.
    pub fn vector_to(self, other: Self) -> Self {
        Self { x: other.x - self.x, y: other.y - self.y, z: other.z - self.z }
    }

    /// The scalar product of two differences.
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The length of a difference, metres.
    pub fn norm(self) -> f64 {
        libm::sqrt(self.dot(self))
    }
}

/// Where the camera is and how it looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Its optical centre.
    pub position: WorldPoint,
    /// 0 along the world's y, positive to the right.
    pub pan: Angle,
    /// 0 level, positive upwards.
    pub tilt: Angle,
    /// About the line of sight, positive where the camera's right side sinks: the horizon then climbs to the
    /// right in the picture.
    pub roll: Angle,
}

/// The axes of a camera in the world: unit vectors.
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
    /// The camera's axes in the world.
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

    /// A place as the camera has it: to the right, down, and ahead of the optical centre, metres.
    pub fn camera_from_world(&self, position: WorldPoint) -> (f64, f64, f64) {
        let axes = self.axes();
        let from_camera = self.position.vector_to(position);
        (from_camera.dot(axes.right), from_camera.dot(axes.down), from_camera.dot(axes.ahead))
    }
}

/// Where a body is and how it lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPose {
    /// Its origin: for a boat, the middle of its waterline.
    pub position: WorldPoint,
    /// Of its bow: 0 along the world's x, anticlockwise as seen from above.
    pub heading: Angle,
    /// Bow up is positive.
    pub pitch: Angle,
    /// Positive where its right side sinks.
    pub roll: Angle,
}
