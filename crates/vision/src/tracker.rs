//! The interface between the pilot and the trackers.

use barrelman_vocab::{Localisation, MotionPrior, PictureSize, PixelBox, PixelPoint, Track, VideoFrame};
use thiserror::Error;

use crate::explanation::Explanation;

/// Follows one selected target from frame to frame.
///
/// `select` tells the tracker what to follow, by a box that the operator dragged. Every video frame is then
/// passed to `track` in the order of capture; gaps are normal. No frame is an error: a target that is not
/// found is a valid answer.
pub trait Tracker: Send {
    /// Makes the content of `selection` on `frame` the target, and forgets an earlier target. The part
    /// outside the picture is cut off. The report contains the localisation on this frame: do not `track` the
    /// same frame.
    ///
    /// # Errors
    /// If the box contains nothing that can be followed. The earlier target is then kept.
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError>;

    /// Localises the target in the next frame. `prior` is the shift of a stationary object in the picture
    /// since the last frame, caused by the camera's motion. Returns [`Track::Unseeded`] before the first
    /// selection.
    fn track(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track;

    /// Whether the target may go bow first, as boats mostly do, in the frames from the next one on. The path of
    /// a boat that is known to go astern, or to drift, does not tell the bow.
    fn set_bow_first(&mut self, _may_be: bool) {}

    /// Forgets the target: the tracker is as before its first selection.
    fn forget(&mut self);

    /// The operator says that the object followed now is not the target. The tracker searches for the target
    /// as it was selected, and does not take that object again while the object can be told from the target.
    /// Returns whether an object was followed. Allocates memory.
    fn reject(&mut self) -> bool;

    /// Writes what the last answer is based on, for an overlay. Costs nothing if it is not called.
    fn explain(&self, out: &mut Explanation);

    /// The shift of the background that the last call of `track` measured; `None`: none was measured.
    fn background_shift(&self) -> Option<BackgroundShift> {
        None
    }
}

/// Shift of the background between two video frames, in the picture around a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BackgroundShift {
    /// To the right, pixels.
    pub u_px: f64,
    /// Downwards, pixels.
    pub v_px: f64,
    /// The centre of the registered part of the picture, in the earlier frame.
    pub centre: PixelPoint,
}

/// Result of a selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionReport {
    /// The box that is used: the part of the selection in the picture, on whole pixels, unless `is_refined`.
    pub used: PixelBox,
    /// Whether part of the selection lies outside the picture and was cut off.
    pub is_clipped: bool,
    /// Whether `used` is not the box that was drawn but a tighter one around the target.
    pub is_refined: bool,
    /// Share of the box's pixels with a usable colour, 0 to 1. CamShift: saturation and value above the
    /// floors. Fused tracker: a colour that is more likely the target's than the surroundings'.
    pub coloured_share: f64,
    /// Mean target probability in a ring around the box, 0 to 1; 0 where the box fills the picture. Near 0
    /// the colour is distinct. CamShift: compare it with the confidence of `localisation`, the same mean
    /// inside the box; where both are similar, the track will drift off. Fused tracker: from about 0.5 on the
    /// colour is not used.
    pub surroundings_probability: f64,
    /// The localisation on the frame of the selection: the box itself, with the target's axes as measured in
    /// it.
    pub localisation: Localisation,
}

/// Why a selection cannot be followed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SelectionError {
    /// A side is zero, negative or not finite.
    #[error(
        "the selection {selection} (left, top, width, height) covers nothing of the {picture} picture: take a box with a width and a height"
    )]
    Empty {
        /// The requested box.
        selection: PixelBox,
        /// Size of the picture.
        picture: PictureSize,
    },
    /// No part of the box lies in the picture.
    #[error(
        "the selection {selection} (left, top, width, height) lies outside the {picture} picture: take a box around the boat within it"
    )]
    Outside {
        /// The requested box.
        selection: PixelBox,
        /// Size of the picture.
        picture: PictureSize,
    },
    /// The part of the box in the picture is too small to learn from.
    #[error(
        "the selection {selection} (left, top, width, height) is too small: take a box around the boat of at least {width} x {height} pixels"
    )]
    TooSmall {
        /// The requested box.
        selection: PixelBox,
        /// Minimum width, pixels.
        width: usize,
        /// Minimum height, pixels.
        height: usize,
    },
    /// No pixel in the box has a usable colour.
    #[error(
        "the selection {selection} (left, top, width, height) of the {picture} picture holds no pixel with saturation of at least {saturation_floor} and \
         value of at least {value_floor} (of 255): select a coloured part of the boat, or lower the floors"
    )]
    Colourless {
        /// The requested box.
        selection: PixelBox,
        /// Size of the picture.
        picture: PictureSize,
        /// Minimum saturation, 0 to 255.
        saturation_floor: u8,
        /// Minimum value, 0 to 255.
        value_floor: u8,
    },
}
