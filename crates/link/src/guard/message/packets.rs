//! Each message as a packet: its kind, then its fields.

use std::time::Duration;

use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates, VesselCommand, VesselOrder};
use barrelman_wire::RestEvidence;

use super::fields::{Fields, put_history, put_rates, put_text, put_vehicle, put_vessel_command};
use super::{FromGuard, MAX_MESSAGE_BYTES, MessageCommand, MessageError, Settings, ToGuard, VERSION};
use crate::dead_mans_switch::RequestedCommand;

impl MessageCommand for VehicleRates {
    fn put(self, out: &mut Vec<u8>) {
        put_rates(out, self);
    }

    fn take(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let mut fields = Fields(bytes);
        Some((fields.rates().ok()?, fields.0))
    }
}

impl MessageCommand for VesselOrder {
    fn put(self, out: &mut Vec<u8>) {
        out.push(u8::from(matches!(self, Self::Commanded(_))));
        put_vessel_command(out, self.command());
    }

    fn take(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let mut fields = Fields(bytes);
        let is_commanded = fields.flag().ok()?;
        let command = fields.vessel_command().ok()?;
        let order = match is_commanded {
            true => Self::Commanded(command),
            false if command == VesselCommand::NEUTRAL => Self::Released,
            false => return None,
        };
        Some((order, fields.0))
    }
}

impl<C: MessageCommand> ToGuard<C> {
    /// The message as a packet.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Vec::new();
        match self {
            Self::Settings(settings) => {
                out.push(1);
                out.extend_from_slice(&VERSION.to_le_bytes());
                out.extend_from_slice(&settings.clock_start_ns.to_le_bytes());
                put_vehicle(&mut out, settings.vehicle);
                put_history(&mut out, settings.history);
                put_text(&mut out, &settings.url);
            }
            Self::Request(RequestedCommand { command, renew_by }) => {
                out.push(2);
                command.put(&mut out);
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
                    vehicle: fields.vehicle()?,
                    history: fields.history()?,
                    url: fields.text()?,
                })
            }
            2 => {
                let (command, rest) = C::take(fields.rest()).ok_or(MessageError::Malformed)?;
                fields = Fields(rest);
                let has_time = fields.flag()?;
                let time = fields.time()?;
                Self::Request(RequestedCommand { command, renew_by: has_time.then_some(time) })
            }
            3 => Self::TakeControl,
            4 => Self::Close,
            _ => return Err(MessageError::Malformed),
        };
        fields.end(message)
    }
}

/// The states of a link, each at the place that its byte names.
pub(super) const STATES: [LinkState; 6] = [
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
            Self::NotOpened { may_pass, reason } => {
                out.extend_from_slice(&[2, u8::from(*may_pass)]);
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
            Self::OpensPort => out.push(13),
            Self::Ended { is_stop_sent } => out.extend_from_slice(&[11, u8::from(*is_stop_sent)]),
            Self::Control { is_anothers } => out.extend_from_slice(&[12, u8::from(*is_anothers)]),
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
            2 => Self::NotOpened { may_pass: fields.flag()?, reason: fields.text()? },
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
            12 => Self::Control { is_anothers: fields.flag()? },
            13 => Self::OpensPort,
            _ => return Err(MessageError::Malformed),
        };
        fields.end(message)
    }
}
