//! The trackers of what is under the operator's marks.
//!
//! ```text
//!  mark is set --an object is proposed there--> followed --tracker loses it--> searched for where it must be
//!                     |                             ^                                  |
//!                     +-- nothing: not held         +-- found there, by the rules of the boat's tracker
//! ```
//!
//! What must not be here: where a mark is on the water (`vessel::marks`), and whether the boat may go there.

use barrelman_vision::{ObjectSizes, Proposer};
use barrelman_vocab::{PixelBox, PixelPoint, Timestamp};

use crate::history::FrameHistory;
use crate::object_trackers::ObjectTrackers;

/// The marks that are held.
#[derive(Default)]
pub(crate) struct HeldMarks {
    /// By the numbers of the marks.
    pub(crate) trackers: ObjectTrackers,
    proposer: Option<Box<Proposer>>,
}

impl HeldMarks {
    /// Begins to hold a mark that was set or moved at a pixel of a video frame. Nothing is held where no
    /// object is found there, where the object is the `boat`, or is held already, and while too many marks
    /// are held.
    pub(crate) fn hold(
        &mut self,
        id: u32,
        (at, captured): (PixelPoint, Timestamp),
        history: &FrameHistory,
        boat: Option<PixelBox>,
    ) {
        self.trackers.keep(|held| held != id);
        let Some(frame) = history.find(captured) else { return };
        let sizes = ObjectSizes::in_picture_of_height(frame.picture.size().height);
        let proposer = self.proposer.get_or_insert_default();
        let Ok(proposed) = proposer.propose(&frame.picture, at, sizes) else { return };
        if !self.trackers.are_at(proposed.bounds, boat) {
            self.trackers.add(id, proposed.bounds, frame);
        }
    }
}
