//! The vehicles that links and faults are measured with. What each measurement needs of a vehicle stands
//! beside the measurement.

use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve};
use barrelman_vocab::{AngularRate, VehicleProfile};
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
    /// An ONVIF camera, whose commands expire: without a guard.
    OnvifPtz,
}

/// The speeds of the ONVIF camera that is measured: 1 rad/s at the speed 1.
pub(crate) fn onvif_speeds() -> AxisSpeeds {
    AxisSpeeds {
        pan: SpeedCurve::linear(AngularRate::from_radians_per_second(1.0)),
        tilt: SpeedCurve::linear(AngularRate::from_radians_per_second(1.0)),
    }
}

impl Vehicle {
    pub(crate) fn profile(self) -> VehicleProfile {
        match self {
            Self::FotokitePro => VehicleProfile::fotokite_pro(),
            Self::MavlinkGimbal => VehicleProfile::mavlink_gimbal(),
            Self::FotokiteSigma => VehicleProfile::fotokite_sigma(),
            Self::OnvifPtz => VehicleProfile::onvif_ptz().with_speeds(onvif_speeds()),
        }
    }
}
