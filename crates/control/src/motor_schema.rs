//! The paper's motor schema: outside the region, turn one axis at a fixed rate (`biswas2017`, algorithm 1).
//!
//! The releaser fires when P > 1; at P = 1 the camera rests. The picture's diagonals, |x| = |y| in pixels
//! (not scaled by the ellipse), divide it into four sectors. In the right and left sectors the camera pans
//! towards the target, in the top and bottom sectors it tilts. On a diagonal, the right half tilts and the
//! left half pans, as in the authors' program (verified on all nine such rows of their 71,914).
//!
//! The rate of the other axis is always zero; inside the region both rates are zero. When the sector changes,
//! the previous axis is set to zero. The authors' program let the previous axis continue until re-entry,
//! while their logs contain the intended zero.
//!
//! The motor schema has no state. Work: O(1), no allocation. It does not decide whether the camera may move,
//! and it knows neither the age of the percept nor the vehicle's signs. `docs/law.md` shows it as a diagram.

use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint};

use crate::percept::Percept;

/// The four sectors between the picture's diagonals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Sector {
    /// Right of both diagonals: pan right.
    Right,
    /// Above both diagonals: tilt up.
    Top,
    /// Left of both diagonals, or on their left halves: pan left.
    Left,
    /// Below both diagonals: tilt down.
    Bottom,
}

impl Sector {
    /// The sector of a point. The centre, where the releaser never fires, counts as the top sector.
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
///
/// ```
/// use barrelman_control::{MotorSchema, Percept, Region};
/// use barrelman_vocab::{ImagePoint, VehicleProfile};
///
/// let rates = VehicleProfile::fotokite_pro().motor_schema_rates;
/// let schema = MotorSchema::new(rates);
/// let region = Region { a_px: 192.0, b_px: 120.0 };
/// let at = |x, y| schema.command(&Percept::new(ImagePoint { x, y }, region));
/// assert!(at(100.0, 0.0).is_rest());
/// assert_eq!(at(250.0, 30.0).pan, rates.pan);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorSchema {
    rates: AxisRates,
}

impl MotorSchema {
    /// A motor schema with these rates (the paper: 0.3 rad/s on both axes).
    pub const fn new(rates: AxisRates) -> Self {
        Self { rates }
    }

    /// Whether the releaser fires: the target is outside of the region. It does not fire if P is NaN.
    pub fn is_released(percept: &Percept) -> bool {
        percept.p > 1.0
    }

    /// The command for this percept.
    pub fn command(&self, percept: &Percept) -> CameraCommand {
        if !Self::is_released(percept) {
            return CameraCommand::REST;
        }
        let pan = |rate| CameraCommand::turning(rate, AngularRate::ZERO);
        let tilt = |rate| CameraCommand::turning(AngularRate::ZERO, rate);
        match Sector::from_point(percept.position) {
            Sector::Right => pan(self.rates.pan),
            Sector::Left => pan(-self.rates.pan),
            Sector::Top => tilt(self.rates.tilt),
            Sector::Bottom => tilt(-self.rates.tilt),
        }
    }
}
