//! How a kite that is not commanded moves all the same, as far as the recorded trials tell: each of its angles
//! and each coordinate of its place wanders by itself.
//!
//! No physics stand behind it: for a kite on its tether in the wind see [`crate::kite`].

use barrelman_vocab::Angle;

use crate::chance::{Draws, Stream, Wander, Wandering};
use crate::pose::WorldPoint;

/// How much it sways.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sway {
    /// About the vertical, radians.
    pub yaw: Wander,
    /// Up and down, radians.
    pub pitch: Wander,
    /// About the line of sight, radians.
    pub roll: Wander,
    /// In each coordinate, metres.
    pub place: Wander,
}

impl Sway {
    /// None at all.
    pub const STILL: Self = {
        let none = Wander { deviation: 0.0, time_s: 1.0 };
        Self { yaw: none, pitch: none, roll: none, place: none }
    };
}

/// A kite that sways.
#[derive(Debug, Clone)]
pub struct Swaying {
    yaw: Wandering,
    pitch: Wandering,
    roll: Wandering,
    place: [Wandering; 3],
}

impl Swaying {
    /// The sway of a trial.
    pub fn new(sway: &Sway, seed: u64) -> Self {
        let wandering = |wander, stream| Wandering::new(wander, Draws::of(seed, stream));
        Self {
            yaw: wandering(sway.yaw, Stream::SwayYaw),
            pitch: wandering(sway.pitch, Stream::SwayPitch),
            roll: wandering(sway.roll, Stream::SwayRoll),
            place: [
                wandering(sway.place, Stream::SwayX),
                wandering(sway.place, Stream::SwayY),
                wandering(sway.place, Stream::SwayZ),
            ],
        }
    }

    /// Advances through a tick.
    pub fn advance(&mut self, tick: u64) {
        self.yaw.advance(tick);
        self.pitch.advance(tick);
        self.roll.advance(tick);
        for coordinate in &mut self.place {
            coordinate.advance(tick);
        }
    }

    /// By what the camera is turned: yaw to the right, pitch upwards, roll with its right side sinking.
    pub const fn turns(&self) -> (Angle, Angle, Angle) {
        (
            Angle::from_radians(self.yaw.value()),
            Angle::from_radians(self.pitch.value()),
            Angle::from_radians(self.roll.value()),
        )
    }

    /// By what it is displaced.
    pub const fn displacement(&self) -> WorldPoint {
        let [x, y, z] = &self.place;
        WorldPoint { x: x.value(), y: y.value(), z: z.value() }
    }
}
