//! Why everything is stopped.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use crate::named::Named;

/// The reason for a stop.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Default,
    Serialize,
    Deserialize,
    JsonSchema,
    IntoStaticStr,
    VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum StopCause {
    /// The operator pressed Stop.
    #[default]
    Operator,
    /// The program is ending (signal, quit key, closed output).
    Ending,
    /// The video ended.
    VideoEnded,
    /// A part of the program failed.
    Fault,
    /// The vehicle no longer accepts commands from this program.
    ControlLost,
    /// The vehicle, or its ground station, restarted.
    VehicleRestarted,
    /// The vehicle reports an emergency.
    Emergency,
    /// The vehicle lands.
    Landing,
    /// A battery of the vehicle became low.
    BatteryLow,
    /// The vehicle fell silent, though its port was open.
    VehicleSilent,
    /// Another gimbal, camera or stream of the vehicle took the place of the one in use.
    Exchanged,
    /// The machine was suspended, or the program did not run for a second or more.
    Suspended,
    /// The picture turned against the commanded pan: the sign of the yaw rate is probably wrong.
    PanOpposed,
    /// The picture turned against the commanded tilt: the sign of the pitch rate is probably wrong.
    TiltOpposed,
}

impl Named for StopCause {
    fn text(self) -> &'static str {
        match self {
            Self::Operator => "by the operator",
            Self::Ending => "ending",
            Self::VideoEnded => "the video ended",
            Self::Fault => "a fault",
            Self::ControlLost => "vehicle gave the control away",
            Self::VehicleRestarted => "vehicle restarted",
            Self::Emergency => "vehicle emergency",
            Self::Landing => "vehicle lands",
            Self::BatteryLow => "battery of the vehicle low",
            Self::VehicleSilent => "vehicle fell silent",
            Self::Exchanged => "another gimbal, camera or stream",
            Self::Suspended => "the program did not run for a while",
            Self::PanOpposed => {
                "the picture turned against the pan: check vehicle.yaw_sign of the configuration"
            }
            Self::TiltOpposed => {
                "the picture turned against the tilt: check vehicle.pitch_sign of the configuration"
            }
        }
    }
}
