//! The seam between the pilot and whatever follows the boat in the picture.

use barrelman_vocab::{Localisation, MotionPrior, PictureSize, PixelBox, Track, VideoFrame};
use thiserror::Error;

use crate::explanation::Explanation;

/// Follows one selected target from frame to frame.
///
/// A tracker is told once what to follow, by a box that an operator dragged, and is then shown every video frame
/// in the order of capture (gaps are normal). It never fails on a frame: a target that is not there is an answer.
pub trait Tracker: Send {
    /// Takes what lies in `selection` on `frame` as the target, and forgets any earlier one. What lies outside the
    /// picture is cut off. The report holds the localisation on this frame: do not `track` it again.
    ///
    /// # Errors
    /// Where nothing in the box can be followed. The earlier target is then kept.
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError>;

    /// Localises the target in the next frame. `prior` says how far a resting thing shifted in the picture since
    /// the frame before because the camera moved. Before the first selection the answer is [`Track::Unseeded`].
    fn track(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track;

    /// Writes what the last answer rests on, for an overlay. It costs nothing where it is not called.
    fn explain(&self, out: &mut Explanation);
}

/// What a tracker made of a selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionReport {
    /// The part of the selection that was used, on whole pixels.
    pub used: PixelBox,
    /// Whether part of the selection lay outside the picture and was cut off.
    pub clipped: bool,
    /// Share of the box's pixels that have a colour to go by, 0 to 1: saturation and value above the floors (CamShift),
    /// or rather the target's colour than its surroundings' (fused tracker).
    pub coloured: f64,
    /// Mean likeness to the target in a ring around the box, 0 to 1; 0 where the box fills the picture. Near 0 the
    /// colour is distinct. CamShift: to be held against the confidence of `localisation`, the same within the box;
    /// where the two are alike, it will wander off. Fused tracker: from about 0.5 on it goes by the pattern alone.
    pub surroundings: f64,
    /// Where the target is on the frame of the selection: the box itself, with the target's axes as measured in it.
    pub localisation: Localisation,
}

/// Why a selection cannot be followed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SelectionError {
    /// A side is zero, negative or not a finite number.
    #[error(
        "the selection {selection} (left, top, width, height) covers nothing of the {picture} picture: take a box with a width and a height"
    )]
    Empty {
        /// The box as it was asked for.
        selection: PixelBox,
        /// The picture that it was dragged on.
        picture: PictureSize,
    },
    /// No part of the box lies in the picture.
    #[error(
        "the selection {selection} (left, top, width, height) lies outside the {picture} picture: take a box around the boat within it"
    )]
    Outside {
        /// The box as it was asked for.
        selection: PixelBox,
        /// The picture that it was dragged on.
        picture: PictureSize,
    },
    /// No pixel in the box has a colour to go by.
    #[error(
        "the selection {selection} (left, top, width, height) of the {picture} picture holds no pixel with saturation of at least {saturation_floor} and \
         value of at least {value_floor} (of 255): select a coloured part of the boat, or lower the floors"
    )]
    Colourless {
        /// The box as it was asked for.
        selection: PixelBox,
        /// The picture that it was dragged on.
        picture: PictureSize,
        /// The least saturation that counts, 0 to 255.
        saturation_floor: u8,
        /// The least value that counts, 0 to 255.
        value_floor: u8,
    },
}
