//! The fields of messages in little-endian order: how each is read, and how it is written.

use barrelman_vocab::mavlink::{Address, ComponentId, MavlinkPeers, SystemId};
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates, VesselCommand};
use barrelman_wire::mavlink::rover::{RoverDrive, RoverLink};
use barrelman_wire::{ByteProtocolName, Framing, LinkHistory, Signing, SigningKey, VesselProtocol};

use super::{GuardedVehicle, MAX_MESSAGE_BYTES, MessageError};

/// The fields of a message, read one after the other.
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    pub(super) fn take<const N: usize>(&mut self) -> Result<[u8; N], MessageError> {
        let (head, rest) = self.0.split_first_chunk::<N>().ok_or(MessageError::Malformed)?;
        self.0 = rest;
        Ok(*head)
    }

    pub(super) fn byte(&mut self) -> Result<u8, MessageError> {
        Ok(self.take::<1>()?[0])
    }

    pub(super) fn flag(&mut self) -> Result<bool, MessageError> {
        match self.byte()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(MessageError::Malformed),
        }
    }

    pub(super) fn number(&mut self) -> Result<u64, MessageError> {
        Ok(u64::from_le_bytes(self.take()?))
    }

    pub(super) fn time(&mut self) -> Result<Timestamp, MessageError> {
        self.number().map(Timestamp::from_nanos)
    }

    pub(super) fn rate(&mut self) -> Result<AngularRate, MessageError> {
        Ok(AngularRate::from_radians_per_second(f64::from_le_bytes(self.take()?)))
    }

    pub(super) fn rates(&mut self) -> Result<VehicleRates, MessageError> {
        let (yaw, pitch) = (self.rate()?, self.rate()?);
        let zoom = f64::from_le_bytes(self.take()?);
        Ok(VehicleRates { yaw, pitch, zoom })
    }

    pub(super) fn vessel_command(&mut self) -> Result<VesselCommand, MessageError> {
        let [throttle, rudder] = [f64::from_le_bytes(self.take()?), f64::from_le_bytes(self.take()?)];
        Ok(VesselCommand { throttle, rudder })
    }

    pub(super) fn vehicle(&mut self) -> Result<GuardedVehicle, MessageError> {
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
        let camera = if self.flag()? { Some(ComponentId(self.byte()?)) } else { None };
        Ok(MavlinkPeers { own, vehicle, device, camera })
    }

    fn system(&mut self) -> Result<Option<SystemId>, MessageError> {
        Ok(if self.flag()? { Some(SystemId(self.byte()?)) } else { None })
    }

    pub(super) fn history(&mut self) -> Result<LinkHistory, MessageError> {
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

    pub(super) fn rest(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.0)
    }

    pub(super) fn text(&mut self) -> Result<String, MessageError> {
        String::from_utf8(self.rest().to_vec()).map_err(|_| MessageError::Malformed)
    }

    pub(super) fn end<T>(self, message: T) -> Result<T, MessageError> {
        if self.0.is_empty() { Ok(message) } else { Err(MessageError::Malformed) }
    }
}

/// Appends the rates: radians per second, and the speed of the zoom.
pub(super) fn put_rates(out: &mut Vec<u8>, rates: VehicleRates) {
    for part in rates.parts() {
        out.extend_from_slice(&part.to_le_bytes());
    }
}

/// Appends throttle and rudder.
pub(super) fn put_vessel_command(out: &mut Vec<u8>, command: VesselCommand) {
    out.extend_from_slice(&command.throttle.to_le_bytes());
    out.extend_from_slice(&command.rudder.to_le_bytes());
}

/// Appends what is guarded.
pub(super) fn put_vehicle(out: &mut Vec<u8>, vehicle: GuardedVehicle) {
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

fn put_peers(out: &mut Vec<u8>, MavlinkPeers { own, vehicle, device, camera }: MavlinkPeers) {
    out.extend_from_slice(&[own.system.0, own.component.0]);
    put_system(out, vehicle);
    out.push(device.unwrap_or(0));
    out.push(u8::from(camera.is_some()));
    out.extend(camera.map(|camera| camera.0));
}

fn put_system(out: &mut Vec<u8>, system: Option<SystemId>) {
    out.push(u8::from(system.is_some()));
    out.extend(system.map(|system| system.0));
}

/// Appends what a guard before has left.
pub(super) fn put_history(
    out: &mut Vec<u8>,
    LinkHistory { may_be_turning, is_anothers, vehicle }: LinkHistory,
) {
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
pub(super) fn put_text(out: &mut Vec<u8>, text: &str) {
    let mut room = MAX_MESSAGE_BYTES.saturating_sub(out.len()).min(text.len());
    while !text.is_char_boundary(room) {
        room -= 1;
    }
    out.extend_from_slice(&text.as_bytes()[..room]);
}
