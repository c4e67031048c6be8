//! A place on Earth, as the page and programs see it.

use barrelman_vocab::earth::{GeoPoint, WaterOnEarth};
use schemars::JsonSchema;
use serde::Serialize;

/// A place on Earth (WGS 84).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PlaceStatus {
    /// Latitude, degrees, positive to the north.
    pub latitude_deg: f64,
    /// Longitude, degrees, positive to the east.
    pub longitude_deg: f64,
}

impl From<GeoPoint> for PlaceStatus {
    fn from(GeoPoint { latitude, longitude }: GeoPoint) -> Self {
        Self { latitude_deg: latitude.degrees(), longitude_deg: longitude.degrees() }
    }
}

/// Where the water lies on Earth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct WaterOnEarthStatus {
    /// The place below the camera, where x and y are zero.
    pub below_camera: PlaceStatus,
    /// Direction of y (ahead of the vehicle) from true north, degrees, positive to the east.
    pub ahead_deg: f64,
}

impl From<WaterOnEarth> for WaterOnEarthStatus {
    fn from(WaterOnEarth { origin, ahead }: WaterOnEarth) -> Self {
        Self { below_camera: origin.into(), ahead_deg: ahead.degrees() }
    }
}
