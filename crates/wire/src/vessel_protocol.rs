//! The protocols of vessels: the only place that chooses a session by the vessel's protocol.

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::mavlink::{MavlinkPeers, SystemId};
use barrelman_vocab::{Timestamp, VesselOrder};

use crate::byte_protocol::{ByteSession, OpenSession, ReportReader};
use crate::lab_udp::LabUdpSession;
use crate::mavlink::RoverSession;
use crate::mavlink::rover::{RoverDrive, RoverLink};
use crate::mavlink::rover_reader::RoverReader;

/// The protocols of vessels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VesselProtocol {
    /// The datagrams of the paper's laboratory.
    LabUdp,
    /// An ArduPilot boat, driven in GUIDED or in MANUAL.
    MavlinkRover(RoverLink),
}

impl VesselProtocol {
    /// The protocol of a vessel's profile; `None`: there is none, or it is not spoken here.
    pub fn of_profile(name: &str) -> Option<Self> {
        match name {
            "lab-udp" => Some(Self::LabUdp),
            "mavlink-rover" => Some(Self::MavlinkRover(RoverLink::GUIDED)),
            "mavlink-rover-manual" => Some(Self::MavlinkRover(RoverLink::MANUAL)),
            _ => None,
        }
    }

    /// The same protocol with the boat of this MAVLink system; `None`: the first boat that is heard. Without
    /// an effect on other protocols.
    #[must_use]
    pub const fn with_vehicle(self, vehicle: Option<SystemId>) -> Self {
        match self {
            Self::LabUdp => self,
            Self::MavlinkRover(link) => {
                let peers = MavlinkPeers { vehicle, ..link.peers };
                Self::MavlinkRover(RoverLink { peers, ..link })
            }
        }
    }

    /// Whether a boat is told from others by its MAVLink system.
    pub const fn has_systems(self) -> bool {
        matches!(self, Self::MavlinkRover(_))
    }

    /// Whether the boat is also reached by a stream of bytes, and not by datagrams alone.
    pub const fn takes_streams(self) -> bool {
        matches!(self, Self::MavlinkRover(_))
    }

    /// What the boat says to commands, in words; `None`: it never says anything.
    pub const fn acceptance_text(self, said: Acceptance) -> Option<&'static str> {
        match self {
            Self::LabUdp => None,
            Self::MavlinkRover(link) => Some(match (said, link.drive) {
                (Acceptance::Accepted, RoverDrive::Guided) => {
                    "the boat is armed and in GUIDED: it takes commands"
                }
                (Acceptance::Accepted, RoverDrive::Manual) => {
                    "the boat is armed and in MANUAL: it takes commands"
                }
                (Acceptance::Disarmed, _) => "the boat is not armed: arm it at its own ground station",
                (Acceptance::ChecksFail, _) => {
                    "the boat is not armed, and its own checks before arming fail: its own texts say which"
                }
                (Acceptance::StartingUp, _) => "the boat's autopilot is still starting: wait",
                (Acceptance::ModeRefused, RoverDrive::Guided) => {
                    "the boat refuses GUIDED: its position estimate (EKF) may not be ready; its own texts say why"
                }
                (Acceptance::ModeRefused, RoverDrive::Manual) => {
                    "the boat refuses MANUAL: its own texts say why"
                }
                (_, RoverDrive::Guided) => {
                    "the boat is not in GUIDED: somebody else steers it. Go asks for GUIDED"
                }
                (_, RoverDrive::Manual) => {
                    "the boat is not in MANUAL: somebody else steers it. Go asks for MANUAL"
                }
            }),
        }
    }
}

impl OpenSession for VesselProtocol {
    type Command = VesselOrder;

    fn open(&self, now: Timestamp) -> Box<ByteSession<VesselOrder>> {
        match *self {
            Self::LabUdp => Box::new(LabUdpSession::open()),
            Self::MavlinkRover(link) => Box::new(RoverSession::open(link, now)),
        }
    }

    fn reports(&self, _: Timestamp) -> ReportReader {
        match *self {
            Self::LabUdp => ReportReader::Silent,
            Self::MavlinkRover(link) => ReportReader::MavlinkRover(Box::new(RoverReader::new(link))),
        }
    }
}
