//! The input of a camera law at one step.

use barrelman_vocab::{ImagePoint, PictureSize, Timestamp};

use crate::percept::Percept;
use crate::region::Region;

/// What a law gets at one step.
#[derive(Debug, Clone, Copy)]
pub struct LawInput<'a> {
    /// Where the target is in the picture.
    pub percept: &'a Percept,
    /// The region that the target may roam in.
    pub region: Region,
    /// Where the destination of the target is, also outside of the picture; `None`: there is none, or it is
    /// behind the camera.
    pub destination: Option<ImagePoint>,
    /// Size of the picture.
    pub picture: PictureSize,
    /// Time of capture of the picture.
    pub captured: Timestamp,
    /// Whether the tracker measured the target in this picture; otherwise `percept` is the tracker's
    /// prediction.
    pub is_measured: bool,
    /// The current time: the command of this step is in force from here on.
    pub now: Timestamp,
}

impl<'a> LawInput<'a> {
    /// The input for a target that was measured, without a destination.
    pub const fn measured(
        percept: &'a Percept,
        region: Region,
        picture: PictureSize,
        captured: Timestamp,
        now: Timestamp,
    ) -> Self {
        Self { percept, region, destination: None, picture, captured, is_measured: true, now }
    }
}
