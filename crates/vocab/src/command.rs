//! Camera commands.

use crate::angle::AngularRate;

/// The commanded pan and tilt rates. Pan > 0 turns the view right and tilt > 0 turns it up, independent of the
/// vehicle's own signs. A command is in force until the next one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraCommand {
    /// Rate about the vertical; positive to the right.
    pub pan: AngularRate,
    /// Rate of elevation; positive upwards.
    pub tilt: AngularRate,
}

impl CameraCommand {
    /// Both axes at rest.
    pub const REST: Self = Self { pan: AngularRate::ZERO, tilt: AngularRate::ZERO };

    /// Whether both rates are zero.
    pub fn is_rest(self) -> bool {
        self.pan.is_zero() && self.tilt.is_zero()
    }
}
