//! Requests and answers over HTTP as packets of the simulated line.
//!
//! ```text
//!   up:   number ' ' method ' ' path '\n' body            one request a packet; a part of one is no request
//!   down: length number status body, little-endian        number 0: a message of the WebSocket; status 0: its end
//! ```
//! A request that gets no answer is given up by the session itself, in the time of its lane.

use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};
use barrelman_wire::http::{HttpCall, Received, Request};
use barrelman_wire::{NextAction, RestEvidence, Session, WillStep};

/// Bytes of a packet before its body: length, number, status.
const HEAD_BYTES: usize = 14;
/// Ends a request. A packet without it was cut.
const END: u8 = b'\0';

/// A request as the vehicle receives it.
#[derive(Debug)]
pub(super) struct ReceivedRequest {
    pub(super) id: u64,
    pub(super) method: String,
    pub(super) path: String,
    pub(super) body: String,
}

impl ReceivedRequest {
    /// Reads a packet; `None`: a part of a request, on which no server acts.
    pub(super) fn read(packet: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(packet.strip_suffix(&[END])?).ok()?;
        let (head, body) = text.split_once('\n')?;
        let mut words = head.splitn(3, ' ');
        let (id, method, path) = (words.next()?, words.next()?, words.next()?);
        Some(Self {
            id: id.parse().ok()?,
            method: method.to_owned(),
            path: path.to_owned(),
            body: body.to_owned(),
        })
    }
}

fn write_request<C: HttpCall>(request: &Request<C>) -> Vec<u8> {
    let method = request.call.method().name();
    let body = request.call.body().unwrap_or_default();
    let mut packet = format!("{} {method} {}\n{body}", request.id, request.call.path()).into_bytes();
    packet.push(END);
    packet
}

/// An answer, a message or the end of the WebSocket as a packet.
pub(super) fn write_received(received: &Received) -> Vec<u8> {
    let (id, status, body): (u64, u16, &[u8]) = match received {
        Received::Answer { id, status, body } => (*id, *status, body),
        Received::Message(body) => (0, 200, body),
        Received::SocketEnded | Received::NoAnswer { .. } => (0, 0, &[]),
    };
    let length = body.len() as u32;
    [&length.to_le_bytes()[..], &id.to_le_bytes(), &status.to_le_bytes(), body].concat()
}

/// Reads whole packets from the front of `bytes`.
fn read_received(mut bytes: &[u8]) -> Vec<Received> {
    let mut packets = Vec::new();
    while let Some((head, rest)) = bytes.split_at_checked(HEAD_BYTES) {
        let field = |at: core::ops::Range<usize>| {
            head[at].iter().rev().fold(0_u64, |value, byte| value << 8 | u64::from(*byte))
        };
        let (length, id, status) = (field(0..4) as usize, field(4..12), field(12..14) as u16);
        let Some((body, rest)) = rest.split_at_checked(length) else { break };
        let body = body.to_vec();
        packets.push(match (id, status) {
            (0, 0) => Received::SocketEnded,
            (0, _) => Received::Message(body),
            _ => Received::Answer { id, status, body },
        });
        bytes = rest;
    }
    packets
}

/// A session with a vehicle over HTTP on the simulated line.
pub(super) struct SessionOverNetwork<S>(pub(super) S);

impl<S, C: HttpCall> Session for SessionOverNetwork<S>
where
    S: Session<Sent = Request<C>, Received = Received, Command = VehicleRates>,
{
    type Sent = Vec<u8>;
    type Received = [u8];
    type Command = VehicleRates;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        let mut requests = Vec::new();
        let next = self.0.poll(now, &mut requests);
        out.extend(requests.iter().map(write_request));
        next
    }

    fn received(&mut self, bytes: &[u8], now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        for packet in read_received(bytes) {
            self.0.received(&packet, now, report);
        }
    }

    fn request(&mut self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        self.0.request(rates, renew_by);
    }

    fn take_control(&mut self, now: Timestamp) {
        self.0.take_control(now);
    }

    fn close(&mut self, now: Timestamp) {
        self.0.close(now);
    }

    fn link_state(&self) -> LinkState {
        self.0.link_state()
    }

    fn may_be_turning(&self) -> bool {
        self.0.may_be_turning()
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        self.0.rest_evidence(now)
    }

    fn last_will(&self, now: Timestamp) -> Vec<WillStep<Vec<u8>>> {
        let step =
            |step: WillStep<Request<C>>| WillStep { packet: write_request(&step.packet), pause: step.pause };
        self.0.last_will(now).into_iter().map(step).collect()
    }
}

#[cfg(test)]
mod tests {
    use barrelman_wire::fotokite_sigma::FotokiteSigmaSession;

    use super::*;

    #[test]
    fn packets_are_read_as_they_were_written() {
        let packets = [
            Received::Answer { id: 7, status: 403, body: b"{}".to_vec() },
            Received::Message(b"{\"pan_ned\":1}".to_vec()),
            Received::SocketEnded,
        ];
        let bytes: Vec<u8> = packets.iter().flat_map(write_received).collect();
        assert_eq!(read_received(&bytes), packets);
        assert_eq!(read_received(&bytes[..bytes.len() - 1]), packets[..2], "what is cut is left out");
    }

    #[test]
    fn a_part_of_a_request_is_none() {
        let mut session = SessionOverNetwork(FotokiteSigmaSession::open(
            None,
            barrelman_vocab::ZoomRate::ZERO,
            Timestamp::ZERO,
        ));
        let mut out = Vec::new();
        session.poll(Timestamp::ZERO, &mut out);
        let request = ReceivedRequest::read(&out[0]).unwrap();
        assert_eq!((request.method.as_str(), request.path.as_str()), ("GET", "/v1/camera/info"));
        assert!(ReceivedRequest::read(&out[0][..out[0].len() - 1]).is_none());
    }
}
