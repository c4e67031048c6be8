//! Whether a vehicle takes camera commands of this program, and why not: for vehicles that answer each
//! command.

use strum::{IntoStaticStr, VariantArray};

use crate::named::Named;

/// What a vehicle says to camera commands of this program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Acceptance {
    /// Commands are accepted.
    Accepted,
    /// Another client has the control, and this program waits for it in the vehicle's queue.
    Queued,
    /// Another client has the control. This program asks for it when the operator engages.
    OtherClient,
    /// Not in this flight state: taking off, landing.
    FlightState,
    /// The vehicle's service is not ready.
    NotReady,
    /// The vehicle reports a fault of a part of its own.
    Fault,
    /// No camera is mounted, or the camera is off line.
    NoCamera,
    /// The vehicle does not know the token, or the token does not permit control.
    TokenRefused,
    /// The vehicle refuses the user or the password, or the user may not move the camera.
    LoginRefused,
    /// How fast the camera turns at its speeds was not measured.
    NotCalibrated,
    /// The vehicle refuses the commands as unusable.
    Unusable,
    /// The vehicle does not answer commands.
    Unanswered,
    /// The vehicle is not armed.
    Disarmed,
    /// The vehicle is not armed, and its own checks before arming fail.
    ChecksFail,
    /// The vehicle's autopilot is starting.
    StartingUp,
    /// The vehicle has refused the mode in which it is commanded.
    ModeRefused,
}

impl Acceptance {
    /// Whether another client has the control, or may have it.
    pub const fn is_elsewhere(self) -> bool {
        matches!(self, Self::Queued | Self::OtherClient | Self::ModeRefused)
    }
}

impl Named for Acceptance {
    /// What it means, and what the operator can do.
    fn text(self) -> &'static str {
        match self {
            Self::Accepted => "the vehicle accepts commands",
            Self::Queued => {
                "another client controls the vehicle; this program waits in its queue until the control is given up"
            }
            Self::OtherClient => "another client controls the vehicle; Engage asks for the control",
            Self::FlightState => "the vehicle takes no camera commands in this flight state",
            Self::NotReady => "the vehicle's service is not ready yet",
            Self::Fault => "the vehicle reports a fault of its own: look at its tablet",
            Self::NoCamera => "the vehicle's camera is not mounted, or off line",
            Self::TokenRefused => {
                "the vehicle refuses the token: put a valid one with the scopes read and control into the token file"
            }
            Self::LoginRefused => {
                "the camera refuses the login, or its user may not move it: give the right one by --link-login-file"
            }
            Self::NotCalibrated => {
                "how fast the camera turns at its speeds is not known: measure it with `barrelman calibrate axes`"
            }
            Self::Unusable => {
                "the vehicle refuses the commands as unusable: compare its camera's limits with the profile's"
            }
            Self::Unanswered => "the vehicle does not answer commands",
            Self::Disarmed => "not armed: arm it at its own ground station",
            Self::ChecksFail => "not armed, and its own checks before arming fail: its own texts say which",
            Self::StartingUp => "the autopilot is still starting: wait",
            Self::ModeRefused => {
                "the mode in which it is steered from here was refused: its position estimate (EKF) may not be ready; its own texts say why"
            }
        }
    }
}
