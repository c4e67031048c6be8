//! Who speaks to which ArduPilot boat, and in which mode it is driven.

use barrelman_vocab::mavlink::{Address, MavlinkPeers};

/// ArduPilot Rover's number of the mode GUIDED.
pub const GUIDED: u32 = 15;
/// ArduPilot Rover's number of the mode MANUAL: the sticks steer, or what overrides them.
pub const MANUAL: u32 = 0;
/// The system id of a ground station that an ArduPilot boat obeys by default (`MAV_GCS_SYSID`).
pub(super) const GROUND_STATION: u8 = 255;

/// How the boat is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoverDrive {
    /// Speed and turn rate, which the autopilot controls.
    Guided,
    /// Throttle and steering, in place of the sticks.
    Manual,
}

impl RoverDrive {
    /// ArduPilot Rover's number of the mode in which the boat is driven.
    pub const fn mode(self) -> u32 {
        match self {
            Self::Guided => GUIDED,
            Self::Manual => MANUAL,
        }
    }
}

/// Who speaks to which boat, and how it is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoverLink {
    /// The addresses.
    pub peers: MavlinkPeers,
    /// How the boat is driven.
    pub drive: RoverDrive,
}

impl RoverLink {
    /// In GUIDED, from an onboard computer.
    pub const GUIDED: Self = Self { peers: MavlinkPeers::DEFAULT, drive: RoverDrive::Guided };
    /// In MANUAL, with the system id of the ground station.
    pub const MANUAL: Self = Self {
        peers: MavlinkPeers { own: Address::new(GROUND_STATION, 191), ..MavlinkPeers::DEFAULT },
        drive: RoverDrive::Manual,
    };
}
