//! The pilot's part of the vessel: what a step tells it.

use barrelman_vocab::{DrawnMark, HoldCause, MarkKind, MovedMark, Timestamp, Track, VesselRequest};

use super::Pilot;
use crate::outcome::{Notice, Refusal};
use crate::safety::ObservationResult;
use crate::vessel::{Observed, VesselNotice, VesselOutcome, VesselView};

impl Pilot {
    /// Processes a request about the vessel. Returns what the operator has to know.
    pub(super) fn on_vessel_request(&mut self, request: &VesselRequest, now: Timestamp) -> Option<Notice> {
        if let VesselRequest::Mark(DrawnMark { captured_ns, .. })
        | VesselRequest::MoveMark(MovedMark { captured_ns, .. }) = request
            && let Some(refusal) = self.other_video(*captured_ns)
        {
            return Some(Notice::RequestRefused(refusal));
        }
        let is_boat_seen = matches!(self.track, Track::Tracking(_))
            && self.drawn_selection.is_none()
            && !self.verification.is_doubted();
        let view = VesselView { camera: self.law.camera(), now };
        let Some(vessel) = &mut self.vessel else {
            return Some(Notice::RequestRefused(Refusal::NoVessel));
        };
        let answer = vessel.on_request(request, self.picture, is_boat_seen, view);
        if answer.is_ok() {
            self.hold_marks(request);
        }
        match answer {
            Ok(notice) => notice.map(|notice| match notice {
                VesselNotice::Marked(id, kind) => Notice::Marked(id, kind),
                VesselNotice::Going(no_water) => Notice::Going(no_water),
            }),
            Err(refusal) => Some(Notice::RequestRefused(refusal)),
        }
    }

    /// Holds the mark that was set or moved by a request, and releases those that are gone.
    fn hold_marks(&mut self, request: &VesselRequest) {
        let Some(vessel) = &self.vessel else { return };
        self.held_marks.trackers.keep(|id| vessel.marks().any(|mark| mark.id == id));
        let (id, at, captured) = match request {
            VesselRequest::Mark(DrawnMark { at, captured_ns, .. }) => (None, *at, *captured_ns),
            VesselRequest::MoveMark(MovedMark { id, at, captured_ns }) => (Some(*id), *at, *captured_ns),
            VesselRequest::Unmark { .. }
            | VesselRequest::UnmarkAll
            | VesselRequest::NextMark
            | VesselRequest::Guide
            | VesselRequest::GoHome
            | VesselRequest::Steer(_)
            | VesselRequest::StopVessel { .. }
            | VesselRequest::ReleaseVessel => return,
        };
        let marked = vessel.marks().filter(|mark| id.is_none_or(|id| mark.id == id)).last();
        if let Some(mark) = marked.filter(|mark| mark.kind == MarkKind::Person) {
            let boat = self.track.localisation().map(|seen| seen.bounds);
            self.held_marks.hold(mark.id, (at, captured), &self.history, boat);
        }
    }

    /// Makes the vessel's part of a step.
    pub(super) fn step_vessel(&mut self, result: ObservationResult, now: Timestamp) -> VesselOutcome {
        let Some(vessel) = &mut self.vessel else { return VesselOutcome::absent() };
        let observed = match (result, &self.track) {
            (ObservationResult::Fresh(_), Track::Tracking(seen)) => Observed::Boat(seen),
            (ObservationResult::Unusable(cause), _) => Observed::NoBoat(cause),
            (ObservationResult::Fresh(_) | ObservationResult::Coasting(_), _) => {
                Observed::NoBoat(HoldCause::Coasting)
            }
            (ObservationResult::NoObservation, _) => Observed::Nothing,
        };
        let newest = self.last_capture.zip(self.picture);
        vessel.step(
            observed,
            newest,
            &mut self.held_marks.trackers,
            VesselView { camera: self.law.camera(), now },
        )
    }
}
