//! The mutant of a session that does not begin with zeros.

use barrelman_vocab::mavlink::SystemId;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};
use barrelman_wire::{ByteSession, LinkHistory, NextAction, RestEvidence, Session, WillStep};

use crate::vehicle::Vehicle;

/// A session without its first zeros.
pub(super) struct WithoutFirstZeros {
    vehicle: Vehicle,
    session: Box<ByteSession>,
    has_begun: bool,
}

impl WithoutFirstZeros {
    pub(super) const fn new(vehicle: Vehicle, session: Box<ByteSession>) -> Self {
        Self { vehicle, session, has_begun: false }
    }
}

impl Session for WithoutFirstZeros {
    type Sent = Vec<u8>;
    type Received = [u8];
    type Command = VehicleRates;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        let mut packets = Vec::new();
        let next = self.session.poll(now, &mut packets);
        if self.vehicle == Vehicle::MavlinkGimbal {
            out.append(&mut packets);
            return next;
        }
        for packet in packets {
            let stop = packet.windows(4).position(|window| window == b"stop");
            if !self.has_begun {
                let Some(stop) = stop else { continue };
                self.has_begun = true;
                out.push([b"\r", &packet[stop..]].concat());
            } else {
                out.push(packet);
            }
        }
        next
    }

    fn received(&mut self, bytes: &[u8], now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        self.session.received(bytes, now, report);
    }

    fn request(&mut self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        self.session.request(rates, renew_by);
    }

    fn close(&mut self, now: Timestamp) {
        self.session.close(now);
    }

    fn link_state(&self) -> LinkState {
        self.session.link_state()
    }

    /// A MAVLink gimbal gets zeros first where a session before may have left it turning.
    fn resume(&mut self, history: LinkHistory) {
        let may_be_turning = history.may_be_turning && self.vehicle != Vehicle::MavlinkGimbal;
        self.session.resume(LinkHistory { may_be_turning, ..history });
    }

    fn vehicle(&self) -> Option<SystemId> {
        self.session.vehicle()
    }

    fn is_anothers(&self) -> bool {
        self.session.is_anothers()
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        self.session.rest_evidence(now)
    }

    fn may_be_turning(&self) -> bool {
        self.session.may_be_turning()
    }

    fn last_will(&self, now: Timestamp) -> Vec<WillStep<Vec<u8>>> {
        self.session.last_will(now)
    }
}
