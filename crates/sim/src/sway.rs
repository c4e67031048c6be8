//! The sway of a platform that is not commanded, as far as the recorded trials tell: each angle and each
//! coordinate is an independent random process.
//!
//! This is a description, not physics; for a kite on its tether in the wind see [`crate::kite`].

use barrelman_vocab::Angle;

use crate::pose::WorldPoint;
use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};

/// Parameters of the sway.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sway {
    /// About the vertical, radians.
    pub yaw: OrnsteinUhlenbeck,
    /// Upwards, radians.
    pub pitch: OrnsteinUhlenbeck,
    /// About the line of sight, radians.
    pub roll: OrnsteinUhlenbeck,
    /// Of each coordinate, metres.
    pub position: OrnsteinUhlenbeck,
}

impl Sway {
    /// No sway.
    pub const STILL: Self = {
        let none = OrnsteinUhlenbeck { std_dev: 0.0, time_constant_s: 1.0 };
        Self { yaw: none, pitch: none, roll: none, position: none }
    };
}

/// A platform that sways.
#[derive(Debug, Clone)]
pub struct SwayingPlatform {
    yaw: OrnsteinUhlenbeckProcess,
    pitch: OrnsteinUhlenbeckProcess,
    roll: OrnsteinUhlenbeckProcess,
    position: [OrnsteinUhlenbeckProcess; 3],
}

impl SwayingPlatform {
    /// The sway of a trial.
    pub fn new(sway: &Sway, seed: u64) -> Self {
        let process = |model, stream| OrnsteinUhlenbeckProcess::new(model, CounterRng::new(seed, stream));
        Self {
            yaw: process(sway.yaw, Stream::SwayYaw),
            pitch: process(sway.pitch, Stream::SwayPitch),
            roll: process(sway.roll, Stream::SwayRoll),
            position: [
                process(sway.position, Stream::SwayX),
                process(sway.position, Stream::SwayY),
                process(sway.position, Stream::SwayZ),
            ],
        }
    }

    /// Advances by a tick.
    pub fn advance(&mut self, tick: u64) {
        self.yaw.advance(tick);
        self.pitch.advance(tick);
        self.roll.advance(tick);
        for coordinate in &mut self.position {
            coordinate.advance(tick);
        }
    }

    /// Offset of the camera's attitude: yaw to the right, pitch upwards, roll with the right side sinking.
    pub const fn attitude_offset(&self) -> (Angle, Angle, Angle) {
        (
            Angle::from_radians(self.yaw.value()),
            Angle::from_radians(self.pitch.value()),
            Angle::from_radians(self.roll.value()),
        )
    }

    /// Displacement of the camera.
    pub const fn displacement(&self) -> WorldPoint {
        let [x, y, z] = &self.position;
        WorldPoint { x: x.value(), y: y.value(), z: z.value() }
    }
}
