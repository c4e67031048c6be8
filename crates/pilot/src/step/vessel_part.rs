//! The pilot's part of the vessel: what a step tells it.

use barrelman_control::CameraLaw;
use barrelman_vocab::{OperatorRequest, Timestamp, Track};

use super::Pilot;
use crate::behaviour;
use crate::outcome::{HoldCause, Notice, Refusal};
use crate::safety::ObservationResult;
use crate::vessel::{Observed, VesselNotice, VesselOutcome, VesselView};

impl Pilot {
    /// Processes a request about the vessel. Returns what the operator has to know.
    pub(super) fn on_vessel_request(&mut self, request: &OperatorRequest, now: Timestamp) -> Option<Notice> {
        let is_boat_seen = matches!(self.track, Track::Tracking(_)) && self.drawn_selection.is_none();
        let view = vessel_view(&self.law, self.behaviour, now);
        let Some(vessel) = &mut self.vessel else {
            return Some(Notice::RequestRefused(Refusal::NoVessel));
        };
        match vessel.on_request(request, self.picture, is_boat_seen, view) {
            Ok(notice) => notice.map(|notice| match notice {
                VesselNotice::Marked(id, kind) => Notice::Marked(id, kind),
                VesselNotice::Going(no_water) => Notice::Going(no_water),
            }),
            Err(refusal) => Some(Notice::RequestRefused(refusal)),
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
        vessel.step(observed, newest, vessel_view(&self.law, self.behaviour, now))
    }
}

/// What a step with these rules tells the vessel's part.
fn vessel_view(law: &CameraLaw, version: u32, now: Timestamp) -> VesselView<'_> {
    VesselView {
        camera: law.camera(),
        now,
        sways: version > behaviour::SURE_SELECTION,
        needs_answer: version > behaviour::DISPLACED_CAMERA,
        needs_places: version > behaviour::ANSWERING_BOAT,
        needs_fix_and_bow: version > behaviour::PLACED_MARKS,
        has_rules_of_9: version > behaviour::BOW_BEFORE_RETREAT,
    }
}
