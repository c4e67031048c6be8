//! Where the held marks are: what their trackers see, put on the water.

use barrelman_vocab::{Localisation, PictureSize, PixelBox, Timestamp, Track};

use super::{VesselPilot, VesselView};
use crate::held_marks::HeldMarks;

impl VesselPilot {
    /// Moves the held marks to where their trackers see them in the newest video frame. What is found after a
    /// loss, and cannot be the marked person by its place, is not taken.
    pub(crate) fn take_sightings(
        &mut self,
        held_marks: &mut HeldMarks,
        boat: Option<&Localisation>,
        (captured, picture): (Timestamp, PictureSize),
        view: VesselView<'_>,
    ) {
        let frame_view = self.frame_view_at(captured, picture, view, self.guide.displacement_at(captured));
        held_marks.trackers.separate(boat.map(|seen| -> PixelBox { seen.bounds }));
        for held in held_marks.trackers.iter_mut() {
            let Some(mark) = self.marks.get_mut(held.id) else { continue };
            if let Track::Tracking(seen) = held.track
                && held.is_current
            {
                if !held.is_back || mark.may_be_at(seen.bounds.centre(), &frame_view, captured) {
                    mark.hold_at(&seen, &frame_view);
                } else {
                    held.lose();
                }
            }
            mark.held = held.reported();
            held.expected = mark.pixel(&frame_view, captured);
        }
    }
}
