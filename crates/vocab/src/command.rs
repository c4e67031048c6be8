//! Camera commands.

use core::time::Duration;

use crate::angle::AngularRate;

/// A command that moves the camera and is not renewed in time ends this much later at the link: the link's dead-man's
/// switch leaves a pilot that is late some room.
pub const RENEWAL_GRACE: Duration = Duration::from_millis(50);

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
