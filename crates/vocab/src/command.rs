//! Camera commands.

use core::time::Duration;

use crate::angle::AngularRate;
use crate::zoom::ZoomRate;

/// A command that moves the camera and is not renewed in time ends this much later at the link: the link's
/// dead-man's switch leaves a pilot that is late some room.
pub const RENEWAL_GRACE: Duration = Duration::from_millis(50);

/// The commanded rates. Pan > 0 turns the view right, tilt > 0 turns it up and zoom > 0 makes it closer,
/// independent of the vehicle's own signs. A command is in force until the next one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraCommand {
    /// Rate about the vertical; positive to the right.
    pub pan: AngularRate,
    /// Rate of elevation; positive upwards.
    pub tilt: AngularRate,
    /// Rate of the zoom; positive to a closer view.
    pub zoom: ZoomRate,
}

impl CameraCommand {
    /// All axes at rest.
    pub const REST: Self = Self::turning(AngularRate::ZERO, AngularRate::ZERO);

    /// A command that turns the camera and does not zoom.
    pub const fn turning(pan: AngularRate, tilt: AngularRate) -> Self {
        Self { pan, tilt, zoom: ZoomRate::ZERO }
    }

    /// The same command with this rate of the zoom.
    #[must_use]
    pub const fn zooming(self, zoom: ZoomRate) -> Self {
        Self { zoom, ..self }
    }

    /// Whether all rates are zero.
    pub fn is_rest(self) -> bool {
        self.pan.is_zero() && self.tilt.is_zero() && self.zoom.is_zero()
    }
}
