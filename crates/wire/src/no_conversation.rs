//! A port that carries bytes, and a vehicle that takes none: every conversation fails, with the reason.

use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};

use crate::session::{NextAction, Session, WillStep};

/// The session of a vehicle that speaks HTTP, on a port that carries bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NoConversation;

impl Session for NoConversation {
    type Sent = Vec<u8>;
    type Received = [u8];

    fn poll(&mut self, _now: Timestamp, _out: &mut Vec<Vec<u8>>) -> NextAction {
        NextAction::Reopen { reason: "this vehicle is reached at an address http://... or https://... alone" }
    }

    fn received(&mut self, _packet: &[u8], _now: Timestamp, _report: &mut dyn FnMut(Telemetry)) {}

    fn request(&mut self, _rates: VehicleRates, _renew_by: Option<Timestamp>) {}

    fn close(&mut self, _now: Timestamp) {}

    fn link_state(&self) -> LinkState {
        LinkState::Opening
    }

    fn may_be_turning(&self) -> bool {
        false
    }

    fn last_will(&self) -> Vec<WillStep<Vec<u8>>> {
        Vec::new()
    }
}
