//! What there is to see at one moment: the seam between the world, which moves, and the renderer, which draws.

use barrelman_vocab::Angle;

use crate::pose::{BodyPose, CameraPose, WorldPoint};

/// The world at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Ticks since the trial's start ([`crate::tick::TICKS_PER_SECOND`] in a second).
    pub tick: u64,
    /// The camera as the picture's first row is taken.
    pub first_row: CameraPose,
    /// The camera as its last row is taken: a rolling shutter takes one after the other.
    pub last_row: CameraPose,
    /// How the light falls.
    pub light: Light,
    /// What is under everything.
    pub ground: Ground,
    /// The target that the trial is about.
    pub target: Target,
    /// Everything else.
    pub objects: Vec<SceneObject>,
    /// How the camera's electronics have it at the moment.
    pub sensor: SensorState,
}

/// The light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Where the sun stands: 0 along the world's y, positive to the right.
    pub sun_bearing: Angle,
    /// Its height above the horizon.
    pub sun_elevation: Angle,
    /// 0: a clear sky; 1: overcast, no sun.
    pub overcast: f64,
}

/// What is under everything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ground {
    /// The laboratory's floor, on which the arena's marks are drawn.
    Floor,
    /// Open water; its waves are those of the scenario's sea.
    Water,
}

/// The target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// A rescue boat.
    Boat(Boat),
    /// The red thing that was moved over the laboratory's floor by hand.
    FloorTarget(BodyPose),
}

/// A rescue boat, as it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boat {
    /// Where it lies and how.
    pub pose: BodyPose,
    /// Its velocity over ground along the world's x and y, m/s.
    pub velocity: (f64, f64),
    /// Thrust of its jet as a share of the largest, -1 to 1.
    pub thrust: f64,
    /// How its jet is turned, positive to the left.
    pub nozzle: Angle,
}

/// A thing that is not the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneObject {
    /// What it is.
    pub kind: ObjectKind,
    /// Where it lies and how.
    pub pose: BodyPose,
    /// What tells it from others of its kind: its paint, its shape.
    pub seed: u64,
}

/// What there may be beside the target.
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
    /// Another craft in the boat's colour, without its deck.
    RedCraft,
    /// A pier of this length and breadth, metres, along its heading, its deck 1.2 m above the water.
    Pier {
        /// Along its heading.
        length_m: f64,
        /// Across.
        breadth_m: f64,
    },
    /// A shore that begins at its place and lies to the left of its heading, with trees, huts, and red and orange
    /// things on it.
    Shore,
}

/// Gains that drift while the camera runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorState {
    /// Brightness, as a factor; 1 is as it should be.
    pub exposure: f64,
    /// Red and blue, as factors; 1 is as it should be.
    pub red: f64,
    /// As `red`.
    pub blue: f64,
    /// How long each row is exposed, seconds.
    pub exposure_s: f64,
}

impl Target {
    /// The middle of its waterline, or where it touches the floor.
    pub fn position(&self) -> WorldPoint {
        match self {
            Self::Boat(boat) => boat.pose.position,
            Self::FloorTarget(pose) => pose.position,
        }
    }
}
