//! Why a boat is guided in the picture, and how the operator confirms it.

use core::time::Duration;

/// A second Go within this time confirms that the boat goes in the picture.
pub const GO_AGAIN: Duration = Duration::from_secs(5);

/// Why a boat is guided in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NoWater {
    /// The height of the camera is not reported, or it is on the ground.
    NoHeight,
    /// The tilt of the camera is not reported.
    NoTilt,
    /// The law steers in the picture.
    Law,
}

impl NoWater {
    /// The reason in words.
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoHeight => "the height of the camera is not reported",
            Self::NoTilt => "the tilt of the camera is not reported",
            Self::Law => "the laboratory's law steers in the picture",
        }
    }
}
