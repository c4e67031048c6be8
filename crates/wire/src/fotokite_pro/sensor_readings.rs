//! What the sensors of a simulated vehicle read.

use barrelman_vocab::Angle;
use barrelman_vocab::telemetry::Quaternion;

/// Readings of the vehicle's sensors, for the telemetry lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorReadings {
    /// Attitude of the flight unit.
    pub attitude: Quaternion,
    /// Attitude of the gimbal.
    pub gimbal: Quaternion,
    /// Angle of the tether from the vertical, rad.
    pub elevation_rad: f64,
    /// Azimuth, rad; positive to the left of the start direction.
    pub azimuth_rad: f64,
    /// Barometric altitude, metres.
    pub altitude_m: f64,
    /// Length of tether paid out, metres.
    pub tether_m: f64,
    /// Voltage of the ground battery, volts.
    pub ground_battery_v: f64,
    /// Voltage of the backup battery, volts.
    pub backup_battery_v: f64,
    /// Flight mode number.
    pub flight_mode: u32,
    /// Warning bits.
    pub flags: u32,
}

impl SensorReadings {
    /// The readings with a level flight unit and the camera straight ahead, 10 m up on a nearly vertical
    /// tether.
    pub const LEVEL: Self = Self {
        attitude: Quaternion { w: 1.0, x: 0.0, y: 0.0, z: 0.0 },
        gimbal: Quaternion { w: 1.0, x: 0.0, y: 0.0, z: 0.0 },
        elevation_rad: 0.2,
        azimuth_rad: 0.0,
        altitude_m: 10.0,
        tether_m: 10.2,
        ground_battery_v: 15.8,
        backup_battery_v: 8.1,
        flight_mode: 2,
        flags: 0,
    };

    /// The readings with the camera at this pan (to the right) and tilt (upwards). The vehicle's yaw is
    /// positive to the left about the vertical, its pitch positive downwards.
    pub fn of_camera(pan: Angle, tilt: Angle) -> Self {
        let (yaw, pitch) = (-pan.radians() / 2.0, -tilt.radians() / 2.0);
        Self {
            attitude: Quaternion { w: libm::cos(yaw), x: 0.0, y: 0.0, z: libm::sin(yaw) },
            gimbal: Quaternion { w: libm::cos(pitch), x: 0.0, y: libm::sin(pitch), z: 0.0 },
            ..Self::LEVEL
        }
    }
}
