//! `sensor_msgs`.

use bytes::Bytes;
use serde::{Serialize, Serializer};

use super::Header;

/// A `uint8[]`, written as one block.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Octets(pub Bytes);

impl Serialize for Octets {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

/// `sensor_msgs/CompressedImage`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CompressedImage {
    /// Time of capture and frame of reference.
    pub header: Header,
    /// The format of the data.
    pub format: &'static str,
    /// The file.
    pub data: Octets,
}

/// `sensor_msgs/NavSatStatus`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct NavSatStatus {
    /// Whether there is a fix, and of which kind.
    pub status: i8,
    /// The satellite systems that were used.
    pub service: u16,
}

impl NavSatStatus {
    /// A place without corrections, and without a satellite receiver of its own.
    pub const PLACE: Self = Self { status: 0, service: 0 };
}

/// `position_covariance_type` of a `sensor_msgs/NavSatFix`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CovarianceType {
    /// The covariance is not known.
    Unknown,
    /// The covariance is an estimate.
    Approximated,
}

impl Serialize for CovarianceType {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(match self {
            Self::Unknown => 0,
            Self::Approximated => 1,
        })
    }
}

/// `sensor_msgs/NavSatFix`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NavSatFix {
    /// Time, and what is at the place.
    pub header: Header,
    /// The kind of fix.
    pub status: NavSatStatus,
    /// Degrees, positive to the north.
    pub latitude: f64,
    /// Degrees, positive to the east.
    pub longitude: f64,
    /// Metres above the ellipsoid; NaN: not known.
    pub altitude: f64,
    /// East, north, up, row by row, m².
    pub position_covariance: [f64; 9],
    /// What is known of the covariance.
    pub position_covariance_type: CovarianceType,
}
