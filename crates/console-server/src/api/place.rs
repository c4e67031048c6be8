//! A place on Earth, as the page and programs see it.

use barrelman_vocab::earth::GeoPoint;
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
