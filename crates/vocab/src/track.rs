//! Results of a tracker: a localisation, and the state of the track.

use core::time::Duration;

use crate::angle::Angle;
use crate::image::{PictureSize, PixelBox, PixelPoint};
use crate::time::Timestamp;

/// The measured position of the target in one video frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Localisation {
    /// Time of capture of the video frame.
    pub captured: Timestamp,
    /// Size of the picture, to which the pixel coordinates refer.
    pub picture: PictureSize,
    /// The target's centre.
    pub centre: PixelPoint,
    /// Upright box around the whole target, clipped to the picture.
    pub bounds: PixelBox,
    /// The target's axes; `None` if the tracker does not measure them.
    pub shape: Option<Shape>,
    /// Direction of the bow, anticlockwise from image right, in [0, 2 pi); `None` if unknown.
    pub heading: Option<Angle>,
    /// The tracker's confidence in the localisation, 0 to 1.
    pub confidence: f64,
}

/// Size and orientation of a target in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Full length of the major axis, pixels.
    pub major_px: f64,
    /// Full length of the minor axis, pixels.
    pub minor_px: f64,
    /// Direction of the major axis, anticlockwise from image right, in [0, pi).
    pub axis: Angle,
}

/// State of the tracked target.
///
/// ```
/// use barrelman_vocab::{Timestamp, Track};
///
/// let track = Track::Lost { since: Timestamp::from_secs_f64(2.0), confidence: 0.1 };
/// assert!(track.localisation().is_none());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Track {
    /// Nothing was selected yet.
    Unseeded,
    /// The target was measured in this video frame.
    Tracking(Localisation),
    /// The target was not measured in this video frame; its position is predicted for a limited time.
    Coasting(Localisation),
    /// The target's position is unknown.
    Lost {
        /// Time of capture of the first video frame in which the target was lost.
        since: Timestamp,
        /// The tracker's confidence in its best candidate position, 0 to 1.
        confidence: f64,
    },
}

impl Track {
    /// The localisation while tracking or coasting.
    pub fn localisation(&self) -> Option<&Localisation> {
        match self {
            Self::Tracking(seen) | Self::Coasting(seen) => Some(seen),
            Self::Unseeded | Self::Lost { .. } => None,
        }
    }
}

/// Predicted shift of the picture since the previous video frame due to camera motion and zoom, from the
/// commands in force. It is an optional input of a tracker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionPrior {
    /// Shift of a stationary object near the picture's centre, pixels, positive to the right (u).
    pub shift_u_px: f64,
    /// The same, positive downwards (v).
    pub shift_v_px: f64,
    /// Standard deviation of each shift, pixels.
    pub std_dev_px: f64,
    /// Present over previous size of a stationary object, above zero: the zoom. 1 without zoom.
    pub scale: f64,
    /// Time between the two video frames.
    pub interval: Duration,
}

impl MotionPrior {
    /// The prior of an object at this point of the previous picture: a zoom moves it away from the picture's
    /// centre, or towards it. Without zoom it is the same prior.
    #[must_use]
    pub fn at(self, point: PixelPoint, picture: PictureSize) -> Self {
        let away = |along: f64, length: u32| (self.scale - 1.0) * (along - 0.5 * f64::from(length));
        Self {
            shift_u_px: self.shift_u_px + away(point.u, picture.width),
            shift_v_px: self.shift_v_px + away(point.v, picture.height),
            ..self
        }
    }
}
