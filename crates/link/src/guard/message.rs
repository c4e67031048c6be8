//! The messages between the program and its guard, one to a packet of the socket pair: a kind, then fields in little-endian
//! order. Times are those of the program's clock, which starts at a stated moment of `CLOCK_MONOTONIC`.

use std::time::Duration;

use barrelman_vocab::mavlink::{Address, MavlinkPeers, SystemId};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{AngularRate, LinkCommand, Timestamp, VehicleRates, VesselCommand, VesselOrder};
use barrelman_wire::mavlink::rover::{RoverDrive, RoverLink};
use barrelman_wire::{
    ByteProtocolName, Framing, LinkHistory, RestEvidence, Signing, SigningKey, VesselProtocol,
};

use crate::dead_mans_switch::RequestedCommand;

/// Version of the messages. Program and guard come from one build; another version is refused.
pub const VERSION: u16 = 7;
/// Largest message, bytes.
pub const MAX_MESSAGE_BYTES: usize = 4096;

/// The first message: what the guard has to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The start of the program's clock on `CLOCK_MONOTONIC`, nanoseconds.
    pub clock_start_ns: u64,
    /// What is guarded.
    pub vehicle: GuardedVehicle,
    /// What a guard before this one has left.
    pub history: LinkHistory,
    /// The address of the link with its deliberate faults.
    pub url: String,
}

/// What a guard has at the other end of its port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GuardedVehicle {
    /// A vehicle with a camera.
    Camera {
        /// The largest rates that may pass, in the vehicle's own axes.
        limits: VehicleRates,
        /// The vehicle's protocol.
        protocol: ByteProtocolName,
        /// The framing of its lines.
        framing: Framing,
    },
    /// A boat.
    Vessel {
        /// The largest throttle and rudder that may pass.
        limits: VesselCommand,
        /// The boat's protocol.
        protocol: VesselProtocol,
    },
}

/// A command that has a form in messages.
pub trait MessageCommand: LinkCommand {
    /// Appends the form of the command.
    fn put(self, out: &mut Vec<u8>);

    /// Reads a command from the beginning of `bytes`. Returns it with the bytes behind it.
    fn take(bytes: &[u8]) -> Option<(Self, &[u8])>;
}

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

/// A message to the guard.
#[derive(Debug, Clone, PartialEq)]
pub enum ToGuard<C = VehicleRates> {
    /// The first message.
    Settings(Settings),
    /// A command with its time to live; also the sign of life.
    Request(RequestedCommand<C>),
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
    /// Whether another client has the control of the vehicle.
    Control {
        /// Whether it has.
        is_anothers: bool,
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
    /// The guard begins to open its port, which may take seconds.
    OpensPort,
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

    fn vessel_command(&mut self) -> Result<VesselCommand, MessageError> {
        let [throttle, rudder] = [f64::from_le_bytes(self.take()?), f64::from_le_bytes(self.take()?)];
        Ok(VesselCommand { throttle, rudder })
    }

    fn vehicle(&mut self) -> Result<GuardedVehicle, MessageError> {
        Ok(match self.byte()? {
            0 => GuardedVehicle::Camera {
                limits: self.rates()?,
                protocol: self.protocol()?,
                framing: if self.flag()? { Framing::LineFeed } else { Framing::CarriageReturns },
            },
            1 => GuardedVehicle::Vessel {
                limits: self.vessel_command()?,
                protocol: match self.byte()? {
                    0 => VesselProtocol::LabUdp,
                    1 => VesselProtocol::MavlinkRover(RoverLink {
                        peers: self.peers()?,
                        drive: if self.flag()? { RoverDrive::Manual } else { RoverDrive::Guided },
                    }),
                    _ => return Err(MessageError::Malformed),
                },
            },
            _ => return Err(MessageError::Malformed),
        })
    }

    fn peers(&mut self) -> Result<MavlinkPeers, MessageError> {
        let own = Address::new(self.byte()?, self.byte()?);
        let vehicle = self.system()?;
        let device = Some(self.byte()?).filter(|device| *device != 0);
        Ok(MavlinkPeers { own, vehicle, device })
    }

    fn system(&mut self) -> Result<Option<SystemId>, MessageError> {
        Ok(if self.flag()? { Some(SystemId(self.byte()?)) } else { None })
    }

    fn history(&mut self) -> Result<LinkHistory, MessageError> {
        let (may_be_turning, is_anothers) = (self.flag()?, self.flag()?);
        Ok(LinkHistory { may_be_turning, is_anothers, vehicle: self.system()? })
    }

    fn protocol(&mut self) -> Result<ByteProtocolName, MessageError> {
        Ok(match self.byte()? {
            0 => ByteProtocolName::FotokitePro,
            1 => {
                let peers = self.peers()?;
                let signing = if self.flag()? {
                    Some(Signing { key: SigningKey::new(self.take()?), began: self.number()? })
                } else {
                    None
                };
                ByteProtocolName::MavlinkGimbal { peers, signing }
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

fn put_vessel_command(out: &mut Vec<u8>, command: VesselCommand) {
    out.extend_from_slice(&command.throttle.to_le_bytes());
    out.extend_from_slice(&command.rudder.to_le_bytes());
}

fn put_vehicle(out: &mut Vec<u8>, vehicle: GuardedVehicle) {
    match vehicle {
        GuardedVehicle::Camera { limits, protocol, framing } => {
            out.push(0);
            put_rates(out, limits);
            put_protocol(out, protocol);
            out.push(match framing {
                Framing::CarriageReturns => 0,
                Framing::LineFeed => 1,
            });
        }
        GuardedVehicle::Vessel { limits, protocol } => {
            out.push(1);
            put_vessel_command(out, limits);
            match protocol {
                VesselProtocol::LabUdp => out.push(0),
                VesselProtocol::MavlinkRover(RoverLink { peers, drive }) => {
                    out.push(1);
                    put_peers(out, peers);
                    out.push(u8::from(drive == RoverDrive::Manual));
                }
            }
        }
    }
}

fn put_peers(out: &mut Vec<u8>, MavlinkPeers { own, vehicle, device }: MavlinkPeers) {
    out.extend_from_slice(&[own.system.0, own.component.0]);
    put_system(out, vehicle);
    out.push(device.unwrap_or(0));
}

fn put_system(out: &mut Vec<u8>, system: Option<SystemId>) {
    out.push(u8::from(system.is_some()));
    out.extend(system.map(|system| system.0));
}

fn put_history(out: &mut Vec<u8>, LinkHistory { may_be_turning, is_anothers, vehicle }: LinkHistory) {
    out.extend_from_slice(&[u8::from(may_be_turning), u8::from(is_anothers)]);
    put_system(out, vehicle);
}

fn put_protocol(out: &mut Vec<u8>, protocol: ByteProtocolName) {
    match protocol {
        ByteProtocolName::FotokitePro => out.push(0),
        ByteProtocolName::MavlinkGimbal { peers, signing } => {
            out.push(1);
            put_peers(out, peers);
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
            12 => Self::Control { is_anothers: fields.flag()? },
            13 => Self::OpensPort,
            _ => return Err(MessageError::Malformed),
        };
        fields.end(message)
    }
}

#[cfg(test)]
mod tests;
