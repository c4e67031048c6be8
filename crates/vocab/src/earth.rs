//! Places on Earth, and where the water frame lies on it.

use crate::angle::Angle;

/// A place on Earth: geodetic coordinates of WGS 84.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeoPoint {
    /// Latitude, -pi/2 to pi/2, positive to the north.
    pub latitude: Angle,
    /// Longitude, -pi to pi, positive to the east.
    pub longitude: Angle,
}

/// Where the water frame ([`crate::WaterPoint`]) lies on Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaterOnEarth {
    /// The place of the frame's origin: below the camera.
    pub origin: GeoPoint,
    /// Direction of the frame's y (ahead at pan 0) from true north, positive to the east.
    pub ahead: Angle,
}
