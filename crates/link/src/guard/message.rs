//! The messages between the program and its guard, one to a packet of the socket pair: a kind, then fields in little-endian
//! order. Times are those of the program's clock, which starts at a stated moment of `CLOCK_MONOTONIC`.

use std::time::Duration;

use barrelman_vocab::mavlink::{Address, MavlinkPeers, SystemId};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};
use barrelman_wire::{ByteProtocolName, Framing, RestEvidence, Signing, SigningKey};

use crate::dead_mans_switch::RequestedRates;

/// Version of the messages. Program and guard come from one build; another version is refused.
pub const VERSION: u16 = 2;
/// Largest message, bytes.
pub const MAX_MESSAGE_BYTES: usize = 4096;

/// The first message: what the guard has to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The start of the program's clock on `CLOCK_MONOTONIC`, nanoseconds.
    pub clock_start_ns: u64,
    /// The largest rates that may pass, in the vehicle's own axes.
    pub limits: VehicleRates,
    /// The vehicle's protocol.
    pub protocol: ByteProtocolName,
    /// The framing of its lines.
    pub framing: Framing,
    /// Whether a guard before this one may have left the camera turning.
    pub may_be_turning: bool,
    /// The address of the link with its deliberate faults.
    pub url: String,
}

/// A message to the guard.
#[derive(Debug, Clone, PartialEq)]
pub enum ToGuard {
    /// The first message.
    Settings(Settings),
    /// Rates with their time to live; also the sign of life.
    Request(RequestedRates),
    /// The operator takes the control of the vehicle back.
    TakeControl,
    /// Zeros, stop, and the end.
    Close,
}

/// A message of the guard.
#[derive(Debug, Clone, PartialEq)]
pub enum FromGuard {
    /// The port was opened.
    Opened,
    /// The port could not be opened at first, for this reason; the guard goes on trying.
    NotOpened(String),
    /// The state of the link.
    State(LinkState, Timestamp),
    /// Bytes of the vehicle.
    Received(Timestamp, Vec<u8>),
    /// The port was lost.
    Lost {
        /// Whether the camera may be turning.
        may_be_turning: bool,
        /// The reason.
        reason: String,
    },
    /// Rates were not renewed in time.
    HeldUp,
    /// The machine was suspended for this long.
    Suspended(Duration),
    /// Zeros and stop were sent.
    Stopped(RestEvidence),
    /// The guard's worker panicked.
    Panicked,
    /// The guard runs.
    Alive,
    /// The guard ends.
    Ended {
        /// Whether zeros and stop were sent.
        is_stop_sent: bool,
    },
}

/// A message cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// The message ends too early, is too long, or has a value that no message has.
    #[error(
        "a message between program and guard cannot be read: is barrelman-guard of the same build as barrelman?"
    )]
    Malformed,
    /// The messages have another version.
    #[error("barrelman-guard is of another build than barrelman: install both together")]
    Version,
}

/// The fields of a message, read one after the other.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], MessageError> {
        let (head, rest) = self.0.split_first_chunk::<N>().ok_or(MessageError::Malformed)?;
        self.0 = rest;
        Ok(*head)
    }

    fn byte(&mut self) -> Result<u8, MessageError> {
        Ok(self.take::<1>()?[0])
    }

    fn flag(&mut self) -> Result<bool, MessageError> {
        match self.byte()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(MessageError::Malformed),
        }
    }

    fn number(&mut self) -> Result<u64, MessageError> {
        Ok(u64::from_le_bytes(self.take()?))
    }

    fn time(&mut self) -> Result<Timestamp, MessageError> {
        self.number().map(Timestamp::from_nanos)
    }

    fn rate(&mut self) -> Result<AngularRate, MessageError> {
        Ok(AngularRate::from_radians_per_second(f64::from_le_bytes(self.take()?)))
    }

    fn rates(&mut self) -> Result<VehicleRates, MessageError> {
        Ok(VehicleRates { yaw: self.rate()?, pitch: self.rate()? })
    }

    fn protocol(&mut self) -> Result<ByteProtocolName, MessageError> {
        Ok(match self.byte()? {
            0 => ByteProtocolName::FotokitePro,
            1 => {
                let own = Address::new(self.byte()?, self.byte()?);
                let vehicle = if self.flag()? { Some(SystemId(self.byte()?)) } else { None };
                let signing = if self.flag()? {
                    Some(Signing { key: SigningKey::new(self.take()?), began: self.number()? })
                } else {
                    None
                };
                ByteProtocolName::MavlinkGimbal { peers: MavlinkPeers { own, vehicle }, signing }
            }
            _ => return Err(MessageError::Malformed),
        })
    }

    fn rest(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.0)
    }

    fn text(&mut self) -> Result<String, MessageError> {
        String::from_utf8(self.rest().to_vec()).map_err(|_| MessageError::Malformed)
    }

    fn end<T>(self, message: T) -> Result<T, MessageError> {
        if self.0.is_empty() { Ok(message) } else { Err(MessageError::Malformed) }
    }
}

fn put_rates(out: &mut Vec<u8>, rates: VehicleRates) {
    for rate in [rates.yaw, rates.pitch] {
        out.extend_from_slice(&rate.radians_per_second().to_le_bytes());
    }
}

fn put_protocol(out: &mut Vec<u8>, protocol: ByteProtocolName) {
    match protocol {
        ByteProtocolName::FotokitePro => out.push(0),
        ByteProtocolName::MavlinkGimbal { peers: MavlinkPeers { own, vehicle }, signing } => {
            out.extend_from_slice(&[1, own.system.0, own.component.0, u8::from(vehicle.is_some())]);
            out.extend(vehicle.map(|system| system.0));
            out.push(u8::from(signing.is_some()));
            if let Some(Signing { key, began }) = signing {
                out.extend_from_slice(&key.bytes());
                out.extend_from_slice(&began.to_le_bytes());
            }
        }
    }
}

/// Text that fits a message; the rest is left out.
fn put_text(out: &mut Vec<u8>, text: &str) {
    let mut room = MAX_MESSAGE_BYTES.saturating_sub(out.len()).min(text.len());
    while !text.is_char_boundary(room) {
        room -= 1;
    }
    out.extend_from_slice(&text.as_bytes()[..room]);
}

impl ToGuard {
    /// The message as a packet.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Vec::new();
        match self {
            Self::Settings(settings) => {
                out.push(1);
                out.extend_from_slice(&VERSION.to_le_bytes());
                out.extend_from_slice(&settings.clock_start_ns.to_le_bytes());
                put_rates(&mut out, settings.limits);
                put_protocol(&mut out, settings.protocol);
                out.push(match settings.framing {
                    Framing::CarriageReturns => 0,
                    Framing::LineFeed => 1,
                });
                out.push(u8::from(settings.may_be_turning));
                put_text(&mut out, &settings.url);
            }
            Self::Request(RequestedRates { rates, renew_by }) => {
                out.push(2);
                put_rates(&mut out, *rates);
                out.push(u8::from(renew_by.is_some()));
                out.extend_from_slice(&renew_by.unwrap_or(Timestamp::ZERO).as_nanos().to_le_bytes());
            }
            Self::TakeControl => out.push(3),
            Self::Close => out.push(4),
        }
        out
    }

    /// Reads a packet.
    ///
    /// # Errors
    /// [`MessageError`]. The guard then closes the link.
    pub fn decode(packet: &[u8]) -> Result<Self, MessageError> {
        let mut fields = Fields(packet);
        let message = match fields.byte()? {
            1 => {
                if u16::from_le_bytes(fields.take()?) != VERSION {
                    return Err(MessageError::Version);
                }
                Self::Settings(Settings {
                    clock_start_ns: fields.number()?,
                    limits: fields.rates()?,
                    protocol: fields.protocol()?,
                    framing: if fields.flag()? { Framing::LineFeed } else { Framing::CarriageReturns },
                    may_be_turning: fields.flag()?,
                    url: fields.text()?,
                })
            }
            2 => {
                let rates = fields.rates()?;
                let has_time = fields.flag()?;
                let time = fields.time()?;
                Self::Request(RequestedRates { rates, renew_by: has_time.then_some(time) })
            }
            3 => Self::TakeControl,
            4 => Self::Close,
            _ => return Err(MessageError::Malformed),
        };
        fields.end(message)
    }
}

const STATES: [LinkState; 6] = [
    LinkState::Opening,
    LinkState::Starting,
    LinkState::Up,
    LinkState::Closing,
    LinkState::Closed,
    LinkState::Silent,
];

impl FromGuard {
    /// The message as a packet.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Vec::new();
        match self {
            Self::Opened => out.push(1),
            Self::NotOpened(reason) => {
                out.push(2);
                put_text(&mut out, reason);
            }
            Self::State(state, at) => {
                let index = STATES.iter().position(|known| known == state).unwrap_or(0);
                out.extend_from_slice(&[3, index as u8]);
                out.extend_from_slice(&at.as_nanos().to_le_bytes());
            }
            Self::Received(at, bytes) => {
                out.push(4);
                out.extend_from_slice(&at.as_nanos().to_le_bytes());
                out.extend_from_slice(&bytes[..bytes.len().min(MAX_MESSAGE_BYTES - out.len())]);
            }
            Self::Lost { may_be_turning, reason } => {
                out.extend_from_slice(&[5, u8::from(*may_be_turning)]);
                put_text(&mut out, reason);
            }
            Self::HeldUp => out.push(6),
            Self::Suspended(duration) => {
                out.push(7);
                out.extend_from_slice(&(duration.as_nanos() as u64).to_le_bytes());
            }
            Self::Stopped(evidence) => {
                let (kind, rate) = match evidence {
                    RestEvidence::AtRest => (0, AngularRate::ZERO),
                    RestEvidence::Moving { rate } => (1, *rate),
                    RestEvidence::NoTelemetry => (2, AngularRate::ZERO),
                };
                out.extend_from_slice(&[8, kind]);
                out.extend_from_slice(&rate.radians_per_second().to_le_bytes());
            }
            Self::Panicked => out.push(9),
            Self::Alive => out.push(10),
            Self::Ended { is_stop_sent } => out.extend_from_slice(&[11, u8::from(*is_stop_sent)]),
        }
        out
    }

    /// Reads a packet.
    ///
    /// # Errors
    /// [`MessageError`]. The program then ends this guard and starts another one.
    pub fn decode(packet: &[u8]) -> Result<Self, MessageError> {
        let mut fields = Fields(packet);
        let message = match fields.byte()? {
            1 => Self::Opened,
            2 => Self::NotOpened(fields.text()?),
            3 => {
                let state =
                    STATES.get(usize::from(fields.byte()?)).copied().ok_or(MessageError::Malformed)?;
                Self::State(state, fields.time()?)
            }
            4 => Self::Received(fields.time()?, fields.rest().to_vec()),
            5 => Self::Lost { may_be_turning: fields.flag()?, reason: fields.text()? },
            6 => Self::HeldUp,
            7 => Self::Suspended(Duration::from_nanos(fields.number()?)),
            8 => {
                let kind = fields.byte()?;
                let rate = fields.rate()?;
                Self::Stopped(match kind {
                    0 => RestEvidence::AtRest,
                    1 => RestEvidence::Moving { rate },
                    2 => RestEvidence::NoTelemetry,
                    _ => return Err(MessageError::Malformed),
                })
            }
            9 => Self::Panicked,
            10 => Self::Alive,
            11 => Self::Ended { is_stop_sent: fields.flag()? },
            _ => return Err(MessageError::Malformed),
        };
        fields.end(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(value: f64) -> AngularRate {
        AngularRate::from_radians_per_second(value)
    }

    #[test]
    fn every_message_is_read_as_it_was_written() {
        let at = Timestamp::from_nanos(12_345_678_901);
        let rates = VehicleRates { yaw: rate(-0.3), pitch: rate(0.1) };
        let settings = Settings {
            clock_start_ns: 77,
            limits: rates,
            protocol: ByteProtocolName::FotokitePro,
            framing: Framing::LineFeed,
            may_be_turning: true,
            url: "tcp://[::1]:5000?fault=stall@3".to_owned(),
        };
        let named = MavlinkPeers { vehicle: Some(SystemId(3)), ..MavlinkPeers::DEFAULT };
        let signing = Some(Signing { key: SigningKey::new([7; 32]), began: 1 << 40 });
        let gimbals =
            [(MavlinkPeers::DEFAULT, None), (named, None), (named, signing)].map(|(peers, signing)| {
                let protocol = ByteProtocolName::MavlinkGimbal { peers, signing };
                Settings { protocol, may_be_turning: false, ..settings.clone() }
            });
        for gimbal in gimbals {
            let message = ToGuard::Settings(gimbal);
            assert_eq!(ToGuard::decode(&message.encode()), Ok(message));
        }
        for message in [
            ToGuard::Settings(settings),
            ToGuard::Request(RequestedRates { rates, renew_by: Some(at) }),
            ToGuard::Request(RequestedRates::REST),
            ToGuard::TakeControl,
            ToGuard::Close,
        ] {
            assert_eq!(ToGuard::decode(&message.encode()), Ok(message));
        }
        let states = STATES.map(|state| FromGuard::State(state, at));
        let others = [
            FromGuard::Opened,
            FromGuard::NotOpened("no such port".to_owned()),
            FromGuard::Received(at, b"!GSStatus 10".to_vec()),
            FromGuard::Lost { may_be_turning: true, reason: "unplugged".to_owned() },
            FromGuard::HeldUp,
            FromGuard::Suspended(Duration::from_millis(1_500)),
            FromGuard::Stopped(RestEvidence::AtRest),
            FromGuard::Stopped(RestEvidence::Moving { rate: rate(0.2) }),
            FromGuard::Stopped(RestEvidence::NoTelemetry),
            FromGuard::Panicked,
            FromGuard::Alive,
            FromGuard::Ended { is_stop_sent: false },
        ];
        for message in states.into_iter().chain(others) {
            assert_eq!(FromGuard::decode(&message.encode()), Ok(message));
        }
    }

    #[test]
    fn what_is_no_message_is_refused() {
        let whole = ToGuard::Request(RequestedRates::REST).encode();
        for length in 0..whole.len() {
            assert!(ToGuard::decode(&whole[..length]).is_err(), "{length} bytes");
        }
        let too_long = [&whole[..], &[0]].concat();
        assert_eq!(ToGuard::decode(&too_long), Err(MessageError::Malformed));
        assert_eq!(ToGuard::decode(&[99]), Err(MessageError::Malformed));
        assert_eq!(ToGuard::decode(&[1, 0xff, 0xff]), Err(MessageError::Version));
        for first in 0..=255 {
            let _ = FromGuard::decode(&[first, 7, 7]);
        }
        assert_eq!(FromGuard::decode(&[3, 6, 0, 0, 0, 0, 0, 0, 0, 0]), Err(MessageError::Malformed));
    }

    #[test]
    fn a_text_that_is_too_long_is_cut_between_characters() {
        let long = FromGuard::NotOpened("ü".repeat(MAX_MESSAGE_BYTES)).encode();
        assert!(long.len() <= MAX_MESSAGE_BYTES);
        assert!(matches!(FromGuard::decode(&long), Ok(FromGuard::NotOpened(_))));
    }
}
