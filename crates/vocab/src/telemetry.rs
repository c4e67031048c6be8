//! Telemetry of a vehicle, independent of the vehicle's protocol.

use crate::acceptance::Acceptance;
use crate::angle::Angle;
use crate::drive_mode::DriveMode;
use crate::equipment::Equipment;
use crate::time::Timestamp;
use crate::vehicle_text::VehicleText;
use crate::zoom::ZoomAbility;

/// One report of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telemetry {
    /// Time of arrival. No supported link timestamps its telemetry.
    pub at: Timestamp,
    /// Content of the report.
    pub report: Report,
}

/// Content of a telemetry message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Report {
    /// The link to the vehicle came up or went down.
    Link(LinkState),
    /// State of the ground station: control and power supply.
    Ground {
        /// Whether the ground station accepts camera commands from this program.
        control: ControlState,
        /// Time since the ground station was switched on, seconds.
        uptime_s: f64,
        /// Battery voltage, volts.
        battery_v: f64,
        /// Length of tether paid out since power-on, metres.
        tether_m: f64,
    },
    /// Who has the control, of a vehicle that reports neither battery nor tether with it.
    Control {
        /// Whether the vehicle accepts camera commands from this program.
        control: ControlState,
        /// Time since the vehicle was switched on, seconds.
        uptime_s: f64,
    },
    /// Attitude of the vehicle: relative to its attitude at initialisation, or to north, east and down
    /// (MAVLink).
    VehicleAttitude(Quaternion),
    /// Attitude of the gimbal, in the vehicle's own frames.
    GimbalAttitude(Quaternion),
    /// Elevation of the camera's axis; positive above the horizon.
    CameraTilt(Angle),
    /// Direction of the camera's axis over the water from true north, 0 to 2 pi, positive to the east.
    CameraHeading(Angle),
    /// Pan of the camera's axis, positive to the right, in the frame in which the vehicle holds a camera at
    /// rest: from its nose, or from north. The zero is the vehicle's own; a change is a turn of the camera.
    CameraPan(Angle),
    /// Height of the camera above the water, metres.
    CameraHeight(f64),
    /// Speed of a vessel over ground, m/s, 0 or more.
    Speed(f64),
    /// The mode of a vessel's autopilot.
    DriveMode(DriveMode),
    /// What the vehicle says in words.
    Text(VehicleText),
    /// Which gimbal, camera or stream is used, of several that a vehicle can have.
    Equipment(Equipment),
    /// Horizontal field of view of the picture. A zoom changes it.
    FieldOfView(Angle),
    /// The pictures are those of another video from now on, which this program tells itself. `Some`: of a
    /// camera of its own with this horizontal field of view, which does not zoom.
    OtherVideo(Option<Angle>),
    /// Whether the camera zooms.
    Zoom(ZoomAbility),
    /// Position of the vehicle on Earth.
    Position {
        /// Latitude (WGS 84), positive to the north.
        latitude: Angle,
        /// Longitude (WGS 84), positive to the east.
        longitude: Angle,
        /// Altitude above the mean sea level, metres.
        altitude_m: f64,
        /// Height above the place of the start, metres.
        height_m: f64,
        /// Direction of the vehicle's nose from north, 0 to 2 pi, positive to the east; `None`: not known.
        heading: Option<Angle>,
    },
    /// Position of the vehicle on its tether.
    Tether {
        /// Angle of the tether from the vertical.
        elevation: Angle,
        /// Angle about the vertical; positive to the left of the start direction.
        azimuth: Angle,
        /// Barometric altitude, metres.
        altitude_m: f64,
    },
    /// State of the flight unit.
    Flight {
        /// Flight state.
        state: FlightState,
        /// Time since the flight unit was switched on, seconds.
        on_time_s: f64,
        /// Voltage of the backup battery, volts.
        backup_battery_v: f64,
        /// The vehicle's warning bits, unchanged.
        warnings: u32,
        /// Whether the vehicle says that one of its batteries is low.
        is_battery_low: bool,
    },
    /// State of the flight, of a vehicle that reports no more of it than this.
    FlightState {
        /// Flight state.
        state: FlightState,
        /// Whether one of the batteries is low.
        is_battery_low: bool,
    },
    /// What the vehicle says to camera commands of this program. Vehicles that answer each command report
    /// this instead of [`Report::Ground`].
    Acceptance(Acceptance),
}

impl Report {
    /// The height of the camera that it tells, metres above the water or the place of the start.
    pub const fn height_m(&self) -> Option<f64> {
        match self {
            Self::CameraHeight(height_m) | Self::Position { height_m, .. } => Some(*height_m),
            Self::Tether { altitude_m, .. } => Some(*altitude_m),
            Self::Link(_)
            | Self::Ground { .. }
            | Self::Control { .. }
            | Self::VehicleAttitude(_)
            | Self::GimbalAttitude(_)
            | Self::CameraTilt(_)
            | Self::CameraHeading(_)
            | Self::CameraPan(_)
            | Self::Speed(_)
            | Self::DriveMode(_)
            | Self::Text(_)
            | Self::Equipment(_)
            | Self::FieldOfView(_)
            | Self::OtherVideo(_)
            | Self::Zoom(_)
            | Self::Flight { .. }
            | Self::FlightState { .. }
            | Self::Acceptance(_) => None,
        }
    }
}

/// State of the link to the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LinkState {
    /// The port is being opened or reopened.
    Opening,
    /// The start-up sequence is running; commands do not reach the camera yet.
    Starting,
    /// Commands reach the camera.
    Up,
    /// The vehicle fell silent though the port is open.
    Silent,
    /// The shut-down sequence is running: zeros, then the vehicle's own stop command.
    Closing,
    /// Closed.
    Closed,
}

/// Whether the vehicle accepts camera commands from this program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ControlState {
    /// Commands are accepted.
    Ours,
    /// Commands are not accepted, and nobody else may command either.
    Unclaimed,
    /// Commands are not accepted: the vehicle is idle, in a menu, or under other control.
    Elsewhere,
}

/// Flight state of the flight unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FlightState {
    /// Motors off.
    Idle,
    /// Flying.
    Flying,
    /// Landing as it was told.
    Landing,
    /// Landing or stopped on the vehicle's own decision.
    Emergency,
    /// A mode number that this program does not know.
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

/// An axis of a frame of reference, about which an Euler angle turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EulerAxis {
    /// Roll in a frame forward, right, down.
    X,
    /// Pitch.
    Y,
    /// Yaw.
    Z,
}

impl Quaternion {
    /// The Euler angle about an axis, of the angles Z, Y, X in this order (yaw, pitch, roll); Y is in -90 to
    /// 90 degrees. `None`: the quaternion has no direction.
    pub fn angle_about(self, axis: EulerAxis) -> Option<Angle> {
        let Self { w, x, y, z } = self;
        let norm = w * w + x * x + y * y + z * z;
        if !norm.is_finite() || norm < 1e-12 {
            return None;
        }
        let angle = match axis {
            EulerAxis::X => libm::atan2(2.0 * (w * x + y * z) / norm, 1.0 - 2.0 * (x * x + y * y) / norm),
            EulerAxis::Y => libm::asin((2.0 * (w * y - z * x) / norm).clamp(-1.0, 1.0)),
            EulerAxis::Z => libm::atan2(2.0 * (w * z + x * y) / norm, 1.0 - 2.0 * (y * y + z * z) / norm),
        };
        Some(Angle::from_radians(angle))
    }

    /// A turn by an angle about one axis.
    pub fn about(axis: EulerAxis, angle: Angle) -> Self {
        let (sin, w) = libm::sincos(angle.radians() / 2.0);
        let turn = Self { w, x: 0.0, y: 0.0, z: 0.0 };
        match axis {
            EulerAxis::X => Self { x: sin, ..turn },
            EulerAxis::Y => Self { y: sin, ..turn },
            EulerAxis::Z => Self { z: sin, ..turn },
        }
    }

    /// The angle of the turn from this attitude to another one, radians, 0 or more. Both are unit quaternions
    /// q and p: the angle is close to twice their distance, 2 |q - p|, and q means the same attitude as -q.
    pub fn angle_to(self, other: Self) -> f64 {
        let distance = |sign: f64| {
            let differences = [
                self.w - sign * other.w,
                self.x - sign * other.x,
                self.y - sign * other.y,
                self.z - sign * other.z,
            ];
            libm::sqrt(differences.iter().map(|difference| difference * difference).sum::<f64>())
        };
        2.0 * distance(1.0).min(distance(-1.0))
    }
}
