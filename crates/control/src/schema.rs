//! The paper's motor schema: outside the ellipse, turn one axis at a fixed rate (`biswas2017`, algorithm 1).
//!
//! The releaser fires when P > 1; P = 1 rests. The picture's diagonals, |x| = |y| in pixels (not scaled by the
//! ellipse), divide it into four sectors: the right and the left one turn the camera by pan, the top and the
//! bottom one by tilt, towards the target. On a diagonal the right-hand half tilts and the left-hand half pans,
//! as the authors' program did (verified on the nine such rows of their 71,914).
//!
//! The other axis is always zero: back inside both are, and the axis that is left when the sector changes is
//! zeroed too. The authors' program let that one run on until re-entry; their logs show the zero that was meant.
//!
//! The schema has no memory: O(1), no allocation. It does not know whether the camera may move, how old the
//! percept is, or which way the vehicle counts. `docs/law.md` draws it.

use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint};

use crate::percept::Percept;

/// The four quarters that the picture's diagonals divide it into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Sector {
    /// Right of both diagonals: pan right.
    Right,
    /// Above both: tilt up.
    Top,
    /// Left of both, and on their left halves: pan left.
    Left,
    /// Below both: tilt down.
    Bottom,
}

impl Sector {
    /// The sector that a point lies in. The centre itself, which no releaser ever fires on, counts as the top.
    pub fn from_point(point: ImagePoint) -> Self {
        let (across, along) = (point.x.abs(), point.y.abs());
        if point.x > 0.0 && across > along {
            Self::Right
        } else if point.x < 0.0 && across >= along {
            Self::Left
        } else if point.y >= 0.0 {
            Self::Top
        } else {
            Self::Bottom
        }
    }
}

/// The motor schema with its fixed rates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorSchema {
    rates: AxisRates,
}

impl MotorSchema {
    /// A schema that turns at these rates (the paper: 0.3 rad/s on both axes).
    pub const fn new(rates: AxisRates) -> Self {
        Self { rates }
    }

    /// Whether the target is outside of the region. A P that is not a number releases nothing.
    pub fn is_released(percept: &Percept) -> bool {
        percept.p > 1.0
    }

    /// What to ask of the camera for this percept.
    pub fn command(&self, percept: &Percept) -> CameraCommand {
        if !Self::is_released(percept) {
            return CameraCommand::REST;
        }
        let pan = |rate| CameraCommand { pan: rate, tilt: AngularRate::ZERO };
        let tilt = |rate| CameraCommand { pan: AngularRate::ZERO, tilt: rate };
        match Sector::from_point(percept.position) {
            Sector::Right => pan(self.rates.pan),
            Sector::Left => pan(-self.rates.pan),
            Sector::Top => tilt(self.rates.tilt),
            Sector::Bottom => tilt(-self.rates.tilt),
        }
    }
}
