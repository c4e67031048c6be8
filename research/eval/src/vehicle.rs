//! The vehicles that links and faults are measured with. What each measurement needs of a vehicle stands beside the measurement.

use barrelman_vocab::VehicleProfile;
use clap::ValueEnum;

/// A vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Vehicle {
    /// A Fotokite Pro, behind a guard.
    FotokitePro,
    /// Any gimbal behind a MAVLink gimbal manager, and a guard.
    MavlinkGimbal,
    /// A Fotokite Sigma, whose commands expire: without a guard.
    FotokiteSigma,
}

impl Vehicle {
    pub(crate) fn profile(self) -> VehicleProfile {
        match self {
            Self::FotokitePro => VehicleProfile::fotokite_pro(),
            Self::MavlinkGimbal => VehicleProfile::mavlink_gimbal(),
            Self::FotokiteSigma => VehicleProfile::fotokite_sigma(),
        }
    }
}
