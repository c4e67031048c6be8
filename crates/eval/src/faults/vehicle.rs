//! The vehicles of the campaign: what is spoken to each, what is at the other end, and which faults each has.

use barrelman_vocab::VehicleProfile;
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing};
use clap::ValueEnum;

use super::fault::{Fault, FaultKind};
use super::fotokite_pro_station::FotokiteProStation;
use super::gimbal_station::GimbalStation;
use super::station::Station;

/// A vehicle whose port carries bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Vehicle {
    /// A Fotokite Pro.
    FotokitePro,
    /// Any gimbal behind a MAVLink gimbal manager.
    MavlinkGimbal,
}

impl Vehicle {
    pub(super) fn profile(self) -> VehicleProfile {
        match self {
            Self::FotokitePro => VehicleProfile::fotokite_pro(),
            Self::MavlinkGimbal => VehicleProfile::mavlink_gimbal(),
        }
    }

    /// What is spoken to the vehicle.
    pub(super) fn protocol(self) -> Option<ByteProtocol> {
        let protocol = ByteProtocolName::of(self.profile().protocol)?;
        Some(ByteProtocol { protocol, framing: Framing::CarriageReturns, baud: 115_200 })
    }

    /// The kinds of faults that the vehicle can have.
    pub(super) const fn faults(self) -> &'static [FaultKind] {
        match self {
            Self::FotokitePro => &FaultKind::OF_FOTOKITE_PRO,
            Self::MavlinkGimbal => &FaultKind::OF_MAVLINK_GIMBAL,
        }
    }

    /// The far end of the line with these faults; `is_worst`: the kind that rests for nothing but zeros.
    pub(super) fn station(self, faults: &[Fault], is_worst: bool) -> Box<dyn Station> {
        match self {
            Self::FotokitePro => Box::new(FotokiteProStation::new(faults, is_worst)),
            Self::MavlinkGimbal => Box::new(GimbalStation::new(faults, is_worst)),
        }
    }
}
