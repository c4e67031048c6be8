//! Where the held marks are: what their trackers see, put on the water.

use barrelman_vocab::{PixelBox, Timestamp, Track};

use super::Marks;
use crate::object_trackers::ObjectTrackers;
use crate::vessel::frame_view::FrameView;

impl Marks {
    /// Moves the held marks to where their trackers see them in the newest video frame. What is found after a
    /// loss, and cannot be the marked person by its place, is not taken.
    pub(in crate::vessel) fn take_sightings(
        &mut self,
        trackers: &mut ObjectTrackers,
        boat: Option<PixelBox>,
        frame_view: &FrameView,
        captured: Timestamp,
    ) {
        trackers.separate(boat);
        for held in trackers.iter_mut() {
            let Some(mark) = self.get_mut(held.id) else { continue };
            if let Track::Tracking(seen) = held.track
                && held.is_current
            {
                if !held.is_back || mark.may_be_at(seen.bounds.centre(), frame_view, captured) {
                    mark.hold_at(&seen, frame_view);
                } else {
                    held.lose();
                }
            }
            mark.held = held.reported();
            held.expected = mark.pixel(frame_view, captured);
        }
    }
}
