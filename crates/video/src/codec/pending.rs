//! Units whose pictures are still in a decoder.

use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::{EncodedUnit, Rotation};
use barrelman_vocab::video::{Capture, CaptureQuality};

/// The properties of a unit that its picture needs, ordered by display time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Pending {
    pub(crate) at: Timestamp,
    /// Pictures that an edit list hides before the start of the video have the time 0 too, and come first.
    pub(crate) shown: bool,
    pub(crate) index: u64,
    pub(crate) quality: CaptureQuality,
    pub(crate) rotation: Rotation,
}

impl Pending {
    pub(crate) fn from_unit(unit: &EncodedUnit) -> Self {
        let Capture { at, quality } = unit.capture;
        Self { at, index: unit.index, quality, shown: unit.shown, rotation: unit.rotation }
    }

    /// The time of capture.
    pub(crate) const fn capture(&self) -> Capture {
        Capture { at: self.at, quality: self.quality }
    }
}
