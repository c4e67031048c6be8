//! The datagrams of the paper's laboratory: throttle and rudder to the boat's control computer, and nothing
//! back.
//!
//! A datagram has 16 bytes: throttle and rudder as little-endian 64-bit floating-point numbers, each -1 to 1
//! (throttle positive ahead, rudder positive to the right). The laboratory's receiver listens at UDP port
//! 5007, turns them into RC values of 1500 + 400 u microseconds, and keeps the last values for ever when
//! nothing arrives. A receiver with a time-out is [`LabReceiver`]; without one, only the guard stands between
//! a lost program and a boat that goes on.
//!
//! The session sends a datagram every [`INTERVAL`] while the boat is commanded, and at once when throttle or
//! rudder change (but no more than one in [`LEAST_INTERVAL`], unless it is neutral). A boat that is released,
//! and the end of the session, get [`NEUTRALS`] neutral datagrams: any of them may be lost.

use core::time::Duration;

use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VesselCommand, VesselOrder};

use crate::session::{NextAction, Session, WillStep};

/// Bytes of a datagram.
pub const DATAGRAM_BYTES: usize = 16;
/// Longest interval between two datagrams.
pub const INTERVAL: Duration = Duration::from_millis(50);
/// Shortest interval between two datagrams that are not neutral.
pub const LEAST_INTERVAL: Duration = Duration::from_millis(10);
/// Neutral datagrams at the end.
pub const NEUTRALS: u32 = 5;
/// The receiver is neutral after this time without a datagram.
pub const RECEIVER_TIMEOUT: Duration = Duration::from_millis(500);
/// RC values: the middle, and the change for a full deflection, microseconds.
const PWM_US: (f64, f64) = (1500.0, 400.0);

/// The datagram of a command.
pub fn encode(command: VesselCommand) -> [u8; DATAGRAM_BYTES] {
    let VesselCommand { throttle, rudder } = command.clamped();
    let mut datagram = [0; DATAGRAM_BYTES];
    datagram[..8].copy_from_slice(&throttle.to_le_bytes());
    datagram[8..].copy_from_slice(&rudder.to_le_bytes());
    datagram
}

/// The command of a datagram, within -1 to 1; `None`: the datagram has another length, or a value that is no
/// number.
pub fn decode(datagram: &[u8]) -> Option<VesselCommand> {
    let (throttle, rest) = datagram.split_first_chunk::<8>()?;
    let rudder: [u8; 8] = rest.try_into().ok()?;
    let (throttle, rudder) = (f64::from_le_bytes(*throttle), f64::from_le_bytes(rudder));
    (!throttle.is_nan() && !rudder.is_nan()).then(|| VesselCommand { throttle, rudder }.clamped())
}

/// The RC values of a command, microseconds: throttle (channel 3) and rudder (channel 1).
pub fn pwm_us(command: VesselCommand) -> (u16, u16) {
    let VesselCommand { throttle, rudder } = command.clamped();
    let value = |share: f64| libm::round(PWM_US.0 + PWM_US.1 * share) as u16;
    (value(throttle), value(rudder))
}

/// The sender's end.
#[derive(Debug, Clone)]
pub struct LabUdpSession {
    order: VesselOrder,
    last: Option<(Timestamp, VesselCommand)>,
    /// Neutral datagrams that are still to be sent of a boat that is released, or of the end.
    neutrals_left: u32,
    is_closing: bool,
}

impl LabUdpSession {
    /// A session on a newly opened port. It begins with neutral datagrams: a session before may have been cut
    /// off.
    pub const fn open() -> Self {
        Self { order: VesselOrder::Released, last: None, neutrals_left: NEUTRALS, is_closing: false }
    }

    fn send(&mut self, command: VesselCommand, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        out.push(encode(command).to_vec());
        self.last = Some((now, command));
    }
}

impl Session for LabUdpSession {
    type Sent = Vec<u8>;
    type Received = [u8];
    type Command = VesselOrder;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        let command = self.order.command();
        let (is_due, has_changed) = self.last.map_or((true, true), |(at, sent)| {
            let since = now.since(at);
            let may_change = since >= LEAST_INTERVAL || command.is_neutral();
            (since >= INTERVAL || now < at, sent != command && may_change)
        });
        match self.order {
            VesselOrder::Commanded(_) if !self.is_closing => {
                if is_due || has_changed {
                    self.send(command, now, out);
                }
                self.neutrals_left = NEUTRALS;
            }
            _ if self.neutrals_left > 0 && (is_due || has_changed) => {
                self.send(VesselCommand::NEUTRAL, now, out);
                self.neutrals_left -= 1;
            }
            _ => {}
        }
        if self.is_closing && self.neutrals_left == 0 {
            return NextAction::Closed;
        }
        if self.order == VesselOrder::Released && self.neutrals_left == 0 {
            // Nothing is owed.
            return NextAction::WaitUntil(now.plus(INTERVAL));
        }
        let last = self.last.map_or(now, |(at, _)| at);
        let wait = if self.last.is_some_and(|(_, sent)| sent != command) { LEAST_INTERVAL } else { INTERVAL };
        NextAction::WaitUntil(last.plus(wait))
    }

    /// The laboratory's receiver answers nothing. Whatever comes is not read.
    fn received(&mut self, _: &[u8], _: Timestamp, _: &mut dyn FnMut(Telemetry)) {}

    fn request(&mut self, order: VesselOrder, _: Option<Timestamp>) {
        self.order = order;
    }

    fn close(&mut self, _: Timestamp) {
        if !self.is_closing {
            (self.is_closing, self.order, self.neutrals_left) = (true, VesselOrder::NEUTRAL, NEUTRALS);
        }
    }

    fn link_state(&self) -> LinkState {
        if self.is_closing { LinkState::Closing } else { LinkState::Up }
    }

    fn may_be_turning(&self) -> bool {
        // A neutral datagram may be lost: only several of them are an end.
        self.last.is_some_and(|(_, sent)| !sent.is_neutral())
            || self.neutrals_left < NEUTRALS && self.neutrals_left > 0
    }

    fn last_will(&self, _: Timestamp) -> Vec<WillStep<Vec<u8>>> {
        let neutral = WillStep { packet: encode(VesselCommand::NEUTRAL).to_vec(), pause: INTERVAL };
        vec![neutral; NEUTRALS as usize]
    }
}

/// The receiver's end, with the time-out that the laboratory's lacks: neutral after [`RECEIVER_TIMEOUT`] of
/// silence.
#[derive(Debug, Clone, Default)]
pub struct LabReceiver {
    heard: Option<(Timestamp, VesselCommand)>,
    /// Datagrams that were not read.
    refused: u64,
}

impl LabReceiver {
    /// A datagram arrived.
    pub fn received(&mut self, datagram: &[u8], now: Timestamp) {
        match decode(datagram) {
            Some(command) => self.heard = Some((now, command)),
            None => self.refused += 1,
        }
    }

    /// The command in force.
    pub fn command(&self, now: Timestamp) -> VesselCommand {
        let fresh = self.heard.filter(|(at, _)| *at <= now && now.since(*at) < RECEIVER_TIMEOUT);
        fresh.map_or(VesselCommand::NEUTRAL, |(_, command)| command)
    }

    /// Datagrams that were not read so far.
    pub const fn refused(&self) -> u64 {
        self.refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos(ms * 1_000_000)
    }

    const AHEAD: VesselCommand = VesselCommand { throttle: 0.6, rudder: -0.25 };

    #[test]
    fn a_datagram_is_that_of_the_laboratory_byte_for_byte() {
        // Python: struct.pack("<dd", 0.6, -0.25)
        let expected = [0x33, 0x33, 0x33, 0x33, 0x33, 0x33, 0xe3, 0x3f, 0, 0, 0, 0, 0, 0, 0xd0, 0xbf];
        assert_eq!(encode(AHEAD), expected);
        assert_eq!(encode(VesselCommand::NEUTRAL), [0; 16]);
        assert_eq!(decode(&expected), Some(AHEAD));
        let beyond = VesselCommand { throttle: 7.0, rudder: f64::NEG_INFINITY };
        assert_eq!(decode(&encode(beyond)), Some(VesselCommand { throttle: 1.0, rudder: -1.0 }));
    }

    #[test]
    fn what_is_no_datagram_is_refused() {
        let mut receiver = LabReceiver::default();
        let nan = [f64::NAN.to_le_bytes(), 0.5_f64.to_le_bytes()].concat();
        for bytes in [&[][..], &[0; 15], &[0; 17], &nan] {
            receiver.received(bytes, at(0));
        }
        assert_eq!((receiver.refused(), receiver.command(at(1))), (4, VesselCommand::NEUTRAL));
    }

    /// What is sent from `from` to `to`, polled each millisecond.
    fn sent(session: &mut LabUdpSession, from: u64, to: u64) -> Vec<(u64, VesselCommand)> {
        let mut all = Vec::new();
        for ms in from..to {
            let mut out = Vec::new();
            session.poll(at(ms), &mut out);
            all.extend(out.iter().map(|datagram| (ms, decode(datagram).unwrap())));
        }
        all
    }

    #[test]
    fn datagrams_come_at_a_steady_rate_and_a_neutral_one_at_once() {
        let mut session = LabUdpSession::open();
        let first = sent(&mut session, 0, 1_000);
        assert_eq!(first.len(), NEUTRALS as usize, "a boat that is not commanded hears no more");
        let next = session.poll(at(1_000), &mut Vec::new());
        assert_eq!(next, NextAction::WaitUntil(at(1_000).plus(INTERVAL)), "and the session waits");
        session.request(VesselOrder::Commanded(AHEAD), Some(at(2_000)));
        let going = sent(&mut session, 1_000, 2_000);
        assert_eq!(going.len(), 20);
        assert!(going.iter().all(|(_, command)| *command == AHEAD));
        session.request(VesselOrder::NEUTRAL, None);
        assert_eq!(sent(&mut session, 2_001, 2_002), [(2_001, VesselCommand::NEUTRAL)]);
    }

    #[test]
    fn every_end_is_neutral_several_times() {
        for ends in [true, false] {
            let mut session = LabUdpSession::open();
            session.request(VesselOrder::Commanded(AHEAD), Some(at(500)));
            sent(&mut session, 0, 300);
            assert!(session.may_be_turning());
            if ends {
                session.close(at(300));
            } else {
                session.request(VesselOrder::Released, None);
            }
            let last = sent(&mut session, 300, 900);
            assert_eq!(last.len(), NEUTRALS as usize);
            assert!(last.iter().all(|(_, command)| command.is_neutral()));
            assert!(!session.may_be_turning());
            assert_eq!(session.poll(at(900), &mut Vec::new()) == NextAction::Closed, ends);
        }
    }

    #[test]
    fn the_receiver_is_neutral_half_a_second_after_the_last_datagram() {
        let mut receiver = LabReceiver::default();
        receiver.received(&encode(AHEAD), at(1_000));
        assert_eq!(pwm_us(receiver.command(at(1_000))), (1740, 1400));
        assert_eq!(receiver.command(at(1_499)), AHEAD);
        assert_eq!(receiver.command(at(1_500)), VesselCommand::NEUTRAL);
        assert_eq!(pwm_us(receiver.command(at(1_500))), (1500, 1500));
        assert_eq!(receiver.command(at(999)), VesselCommand::NEUTRAL, "a clock that went back");
    }
}
