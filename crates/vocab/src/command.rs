//! What is asked of the camera.

use crate::angle::AngularRate;

/// Rates of the camera, inside: pan > 0 turns the view right, tilt > 0 raises it, whatever the vehicle's own
/// signs are. A command is in force until the next one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraCommand {
    /// Turn of the view about the vertical; positive to the right.
    pub pan: AngularRate,
    /// Turn of the view up and down; positive upwards.
    pub tilt: AngularRate,
}

impl CameraCommand {
    /// Both axes at rest.
    pub const REST: Self = Self { pan: AngularRate::ZERO, tilt: AngularRate::ZERO };

    /// Whether no motion is asked for on either axis.
    pub fn is_rest(self) -> bool {
        self.pan.is_zero() && self.tilt.is_zero()
    }
}
