//! What is visible at one moment: the interface between the world and the renderer.

use barrelman_vocab::Angle;

use crate::pose::{BodyPose, CameraPose, WorldPoint};

/// The visible world at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Ticks since the start of the trial ([`crate::tick::TICKS_PER_SECOND`]).
    pub tick: u64,
    /// Camera pose when the first row is exposed.
    pub first_row: CameraPose,
    /// Camera pose when the last row is exposed (rolling shutter).
    pub last_row: CameraPose,
    /// Focal length of the camera over that of the renderer's settings: its zoom.
    pub zoom: f64,
    /// Sun and sky.
    pub light: Light,
    /// The ground under all objects.
    pub ground: Ground,
    /// The target of the trial.
    pub target: Target,
    /// All other objects.
    pub objects: Vec<SceneObject>,
    /// Present state of the camera's electronics.
    pub sensor: SensorState,
}

/// Sun and sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Bearing of the sun: 0 along the world's y, positive to the right.
    pub sun_bearing: Angle,
    /// Elevation of the sun above the horizon.
    pub sun_elevation: Angle,
    /// 0: a clear sky; 1: overcast, no sun.
    pub overcast: f64,
}

/// The ground under all objects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ground {
    /// The laboratory's floor with the marks of its arena.
    Floor,
    /// Open water; the renderer's settings hold its waves.
    Water,
}

/// The target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// A rescue boat.
    Boat(Boat),
    /// The red target that was moved over the laboratory's floor by hand.
    FloorTarget(BodyPose),
}

/// Visible state of a rescue boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boat {
    /// Position and attitude.
    pub pose: BodyPose,
    /// Velocity over ground along the world's x and y, m/s.
    pub velocity: (f64, f64),
    /// Thrust of the jet as a share of full thrust, -1 to 1.
    pub thrust: f64,
    /// Angle of the nozzle, positive to the left.
    pub nozzle: Angle,
}

/// An object other than the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneObject {
    /// What the object is.
    pub kind: ObjectKind,
    /// Position and attitude.
    pub pose: BodyPose,
    /// Seed of the object's individual appearance.
    pub seed: u64,
}

/// Kinds of objects beside the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObjectKind {
    /// A mark of the arena, painted on the floor.
    FloorMark,
    /// A buoy.
    Buoy,
    /// A small yellow buoy that marks the arena on the water.
    MarkBuoy,
    /// A life jacket, adrift.
    LifeJacket,
    /// A person in the water.
    Swimmer,
    /// Another craft in the boat's colour, without deck gear.
    RedCraft,
    /// A pier along its heading, its deck 1.2 m above the water.
    Pier {
        /// Length along the heading, metres.
        length_m: f64,
        /// Breadth, metres.
        breadth_m: f64,
    },
    /// A shore that begins at its position and lies to the left of its heading, with trees, huts, and red and
    /// orange crates.
    Shore,
}

/// Drifting gains of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorState {
    /// Brightness factor; nominally 1.
    pub exposure: f64,
    /// Gain of red; nominally 1.
    pub red: f64,
    /// Gain of blue; nominally 1.
    pub blue: f64,
    /// Exposure time of each row, seconds.
    pub exposure_s: f64,
}

impl Target {
    /// Middle of the waterline, or the point of contact with the floor.
    pub fn position(&self) -> WorldPoint {
        match self {
            Self::Boat(boat) => boat.pose.position,
            Self::FloorTarget(pose) => pose.position,
        }
    }
}
