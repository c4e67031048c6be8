//! The pilot's part of a tap: the proposal, and its selection.

use barrelman_vocab::{CameraRequest, Tap, Timestamp, Track};

use super::Pilot;
use crate::outcome::Notice;
use crate::proposing::ProposedObject;

impl Pilot {
    /// Takes the proposal that is tapped, or proposes the object at the tap.
    pub(super) fn on_tap(&mut self, tap: Tap, now: Timestamp) -> Option<Notice> {
        if let Some(object) = self.proposals.take_at(tap.at) {
            return self.select_proposed(&object, now);
        }
        if let Some(candidate) = self.candidates.at(tap.at).filter(|_| self.track == Track::Unseeded) {
            return self.on_camera_request(&CameraRequest::Select(candidate.selection()), now);
        }
        match self.proposals.propose(tap, &self.history) {
            Ok(object) if tap.take => self.select_proposed(&object, now),
            Ok(object) => Some(Notice::Proposed(object.bounds)),
            Err(refusal) => Some(Notice::RequestRefused(refusal)),
        }
    }

    /// Takes the proposal that stands if nothing is followed: the camera was engaged to follow it.
    pub(super) fn take_proposal_to_follow(&mut self, now: Timestamp) -> Option<Notice> {
        let is_selecting = self.drawn_selection.is_some() || self.pending_selection.is_some();
        if is_selecting || self.track != Track::Unseeded {
            return None;
        }
        let object = self.proposals.take()?;
        self.select_proposed(&object, now)
    }

    fn select_proposed(&mut self, object: &ProposedObject, now: Timestamp) -> Option<Notice> {
        self.on_camera_request(&CameraRequest::Select(object.selection()), now)
    }
}
