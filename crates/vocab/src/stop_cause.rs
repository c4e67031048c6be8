//! Why everything is stopped.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The reason for a stop.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
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
    /// The machine was suspended, or the program did not run for a second or more.
    Suspended,
    /// The picture turned against the commanded pan: the sign of the yaw rate is probably wrong.
    PanOpposed,
    /// The picture turned against the commanded tilt: the sign of the pitch rate is probably wrong.
    TiltOpposed,
}
