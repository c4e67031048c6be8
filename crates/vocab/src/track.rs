//! What a tracker says: one localisation, and the state of the track.

use core::time::Duration;

use crate::angle::Angle;
use crate::image::{PictureSize, PixelBox, PixelPoint};
use crate::time::Timestamp;

/// Where the target is in one video frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Localisation {
    /// Time of capture of the frame that it was measured in.
    pub captured: Timestamp,
    /// Size of that picture: what the pixel coordinates count in.
    pub picture: PictureSize,
    /// The target's centre.
    pub centre: PixelPoint,
    /// Upright box around the whole target, clipped to the picture.
    pub bounds: PixelBox,
    /// The target's axes, where the tracker measures them.
    pub shape: Option<Shape>,
    /// Where the bow points, anticlockwise from image right, 0 to 2 pi; absent when it is not known.
    pub heading: Option<Angle>,
    /// How much the tracker believes in it, 0 to 1.
    pub confidence: f64,
}

/// Size and orientation of a target in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Full length of the major axis, pixels.
    pub major_px: f64,
    /// Full length of the minor axis, pixels.
    pub minor_px: f64,
    /// Direction of the major axis, anticlockwise from image right as seen, 0 (inclusive) to pi (exclusive).
    pub axis: Angle,
}

/// The target followed in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Track {
    /// Nothing was selected yet.
    Unseeded,
    /// Seen in this frame.
    Tracking(Localisation),
    /// Not seen in this frame, but where it must be is known well enough to go on for a while.
    Coasting(Localisation),
    /// Not known where the target is.
    Lost {
        /// Time of capture of the first frame in which it was lost.
        since: Timestamp,
        /// How much the tracker believes in the best place it knows, 0 to 1.
        confidence: f64,
    },
}

impl Track {
    /// The localisation, if the target's place is known (tracking or coasting).
    pub fn localisation(&self) -> Option<&Localisation> {
        match self {
            Self::Tracking(seen) | Self::Coasting(seen) => Some(seen),
            Self::Unseeded | Self::Lost { .. } => None,
        }
    }
}

/// How the picture shifted since the last frame because the camera moved, from the commands in force.
/// A tracker works without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionPrior {
    /// Shift of a resting thing near the picture's centre, pixels, u to the right.
    pub shift_u_px: f64,
    /// The same, v downwards.
    pub shift_v_px: f64,
    /// Standard deviation of both shifts, pixels.
    pub std_dev_px: f64,
    /// Time between the two frames that it speaks of.
    pub interval: Duration,
}
