//! The pilot's part of the vessel: what a step tells it.

use barrelman_vocab::{HoldCause, Timestamp, Track, VesselRequest};

use super::Pilot;
use crate::outcome::{Notice, Refusal};
use crate::safety::ObservationResult;
use crate::vessel::{Observed, VesselNotice, VesselOutcome, VesselView};

impl Pilot {
    /// Processes a request about the vessel. Returns what the operator has to know.
    pub(super) fn on_vessel_request(&mut self, request: &VesselRequest, now: Timestamp) -> Option<Notice> {
        let is_boat_seen = matches!(self.track, Track::Tracking(_)) && self.drawn_selection.is_none();
        let view = VesselView { camera: self.law.camera(), now };
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
        vessel.step(observed, newest, VesselView { camera: self.law.camera(), now })
    }
}
