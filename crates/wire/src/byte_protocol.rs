//! The protocols of ports that carry bytes: the only place that chooses a session over bytes by the profile's
//! [`Protocol`].

use barrelman_vocab::mavlink::{MavlinkPeers, SystemId};
use barrelman_vocab::profile::Protocol;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{LinkCommand, Timestamp, VehicleRates};

use crate::fotokite_pro::telemetry_reader::Received;
use crate::fotokite_pro::{FotokiteProSession, SessionSettings, TelemetryReader};
use crate::framing::Framing;
use crate::mavlink::gimbal_reader::Received as GimbalReceived;
use crate::mavlink::rover_reader::RoverReader;
use crate::mavlink::signing::Signing;
use crate::mavlink::{GimbalReader, GimbalSession};
use crate::session::Session;

/// A session over bytes: a serial port, a TCP connection, or datagrams.
pub type ByteSession<C = VehicleRates> = dyn Session<Sent = Vec<u8>, Received = [u8], Command = C>;

/// What a link over bytes has to know of a protocol: it opens sessions, and reads the vehicle's reports.
pub trait OpenSession: Copy + Send + Sync + 'static {
    /// What the vehicle is told.
    type Command: LinkCommand;

    /// A session on a newly opened port.
    fn open(&self, now: Timestamp) -> Box<ByteSession<Self::Command>>;

    /// A reader of the vehicle's reports, for received bytes that a session in another process has received,
    /// too.
    fn reports(&self, now: Timestamp) -> ReportReader;
}

/// The protocols that are spoken over bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteProtocolName {
    /// The Fotokite Pro ground station's serial text protocol.
    FotokitePro,
    /// A MAVLink gimbal manager.
    MavlinkGimbal {
        /// Who speaks to whom.
        peers: MavlinkPeers,
        /// How packets are signed; `None`: they are not, and signatures of received ones are not looked at.
        signing: Option<Signing>,
    },
}

impl ByteProtocolName {
    /// The name of a vehicle's protocol; `None`: it is not spoken over bytes.
    pub const fn of(protocol: Protocol) -> Option<Self> {
        match protocol {
            Protocol::FotokitePro => Some(Self::FotokitePro),
            Protocol::FotokiteSigma | Protocol::OnvifPtz => None,
            Protocol::MavlinkGimbal(peers) => Some(Self::MavlinkGimbal { peers, signing: None }),
        }
    }

    /// The same protocol with signed packets, where packets can be signed.
    #[must_use]
    pub const fn signed(self, signing: Option<Signing>) -> Self {
        match self {
            Self::FotokitePro => self,
            Self::MavlinkGimbal { peers, .. } => Self::MavlinkGimbal { peers, signing },
        }
    }
}

/// A protocol over bytes, with what its sessions have to know about the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ByteProtocol {
    /// The protocol.
    pub protocol: ByteProtocolName,
    /// The framing of text lines, where the protocol has some.
    pub framing: Framing,
    /// What the line carries, bits per second.
    pub baud: u32,
}

impl OpenSession for ByteProtocol {
    type Command = VehicleRates;

    fn open(&self, now: Timestamp) -> Box<ByteSession> {
        match self.protocol {
            ByteProtocolName::FotokitePro => {
                let settings = SessionSettings::for_baud(self.framing, self.baud);
                Box::new(FotokiteProSession::open(settings, now))
            }
            ByteProtocolName::MavlinkGimbal { peers, signing } => {
                Box::new(GimbalSession::open(peers, signing, now))
            }
        }
    }

    fn reports(&self, now: Timestamp) -> ReportReader {
        match self.protocol {
            ByteProtocolName::FotokitePro => ReportReader::FotokitePro(TelemetryReader::default()),
            ByteProtocolName::MavlinkGimbal { peers, signing } => {
                ReportReader::MavlinkGimbal(Box::new(GimbalReader::new(peers, signing, now)))
            }
        }
    }
}

/// Reads the reports of a vehicle from received bytes.
#[derive(Debug, Clone)]
pub enum ReportReader {
    /// Those of a Fotokite Pro.
    FotokitePro(TelemetryReader),
    /// Those of a MAVLink gimbal manager.
    MavlinkGimbal(Box<GimbalReader>),
    /// Those of a MAVLink boat.
    MavlinkRover(Box<RoverReader>),
    /// None: the vehicle says nothing.
    Silent,
}

impl ReportReader {
    /// The MAVLink system whose reports are read, where one is known.
    pub fn vehicle(&self) -> Option<SystemId> {
        match self {
            Self::FotokitePro(_) | Self::Silent => None,
            Self::MavlinkGimbal(reader) => reader.vehicle(),
            Self::MavlinkRover(reader) => reader.vehicle(),
        }
    }

    /// From now on only this system's reports are read.
    pub fn name(&mut self, vehicle: SystemId) {
        match self {
            Self::FotokitePro(_) | Self::Silent => {}
            Self::MavlinkGimbal(reader) => reader.name(vehicle),
            Self::MavlinkRover(reader) => reader.name(vehicle),
        }
    }

    /// Passes each report in received bytes to `each`.
    pub fn read(&mut self, bytes: &[u8], mut each: impl FnMut(Report)) {
        match self {
            Self::FotokitePro(reader) => reader.read(bytes, |received| {
                if let Received::Report(report) = received {
                    each(report);
                }
            }),
            Self::Silent => {}
            Self::MavlinkRover(reader) => {
                reader.read(bytes, each);
            }
            Self::MavlinkGimbal(reader) => reader.read(bytes, |received| {
                if let GimbalReceived::Report(report) = received {
                    each(report);
                }
            }),
        }
    }
}
