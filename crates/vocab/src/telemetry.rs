//! What a vehicle says of itself, in no vehicle's own words.

use crate::angle::Angle;
use crate::time::Timestamp;

/// One report of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telemetry {
    /// When it arrived: none of the links known so far stamps its telemetry.
    pub at: Timestamp,
    /// What it says.
    pub report: Report,
}

/// What a telemetry message says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Report {
    /// The link to the vehicle came up or went down.
    Link(LinkState),
    /// The ground station: who is in control, and its supply.
    Ground {
        /// Whether it takes our camera commands.
        control: ControlState,
        /// Time since it was switched on, seconds.
        uptime_s: f64,
        /// Battery, volts.
        battery_v: f64,
        /// Tether paid out since power-on, metres.
        tether_m: f64,
    },
    /// Attitude of the vehicle relative to where it was initialised.
    VehicleAttitude(Quaternion),
    /// Attitude of the gimbal, in the vehicle's own frames.
    GimbalAttitude(Quaternion),
    /// Where the camera's axis points: above the horizon positive.
    CameraTilt(Angle),
    /// How much of the world the picture shows from its left edge to its right: it changes where a camera zooms.
    FieldOfView(Angle),
    /// Where the vehicle stands on its tether.
    Tether {
        /// Angle of the tether from the vertical.
        elevation: Angle,
        /// Angle about the vertical, positive to the left of the start direction.
        azimuth: Angle,
        /// Barometric altitude, metres.
        altitude_m: f64,
    },
    /// The flight unit.
    Flight {
        /// Whether it is airborne and well, landing, or down.
        state: FlightState,
        /// Time since it was switched on, seconds.
        on_time_s: f64,
        /// Backup battery, volts.
        backup_battery_v: f64,
        /// The vehicle's own warning bits, as sent.
        warnings: u32,
    },
}

/// State of the link to the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LinkState {
    /// The port is being opened, or opened anew.
    Opening,
    /// The start-up sequence is under way: commands do not reach the camera yet.
    Starting,
    /// Commands reach the camera.
    Up,
    /// The last commands are being sent: zeros and the vehicle's own stop.
    Closing,
    /// Closed.
    Closed,
}

/// Whether the vehicle takes camera commands from us.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ControlState {
    /// It does.
    Ours,
    /// It does not: idle, in a menu, or controlled by another.
    NotOurs,
}

/// What the flight unit is doing, as far as the camera's pilot needs to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FlightState {
    /// Motors off.
    Idle,
    /// Flying.
    Flying,
    /// Coming down, or stopped, for its own reasons.
    Emergency,
    /// A mode that this program does not know, by its number.
    Other(u32),
}

/// A unit quaternion, w first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quaternion {
    /// Scalar part.
    pub w: f64,
    /// First vector component.
    pub x: f64,
    /// Second vector component.
    pub y: f64,
    /// Third vector component.
    pub z: f64,
}
