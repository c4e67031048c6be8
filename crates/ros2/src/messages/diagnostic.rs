//! `diagnostic_msgs`.

use serde::{Serialize, Serializer};

use super::Header;

/// `level` of a `diagnostic_msgs/DiagnosticStatus`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// As wanted.
    Ok,
    /// To be watched.
    Warn,
    /// Something has failed.
    Error,
    /// Nothing is heard.
    Stale,
}

impl Serialize for Level {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(match self {
            Self::Ok => 0,
            Self::Warn => 1,
            Self::Error => 2,
            Self::Stale => 3,
        })
    }
}

/// `diagnostic_msgs/KeyValue`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct KeyValue {
    /// What it is.
    pub key: String,
    /// Its value.
    pub value: String,
}

/// `diagnostic_msgs/DiagnosticStatus`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct DiagnosticStatus {
    /// How good or bad the state is.
    pub level: Level,
    /// What the state is of.
    pub name: String,
    /// The state.
    pub message: String,
    /// The vehicle.
    pub hardware_id: String,
    /// The figures.
    pub values: Vec<KeyValue>,
}

/// `diagnostic_msgs/DiagnosticArray`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct DiagnosticArray {
    /// The time.
    pub header: Header,
    /// The states.
    pub status: Vec<DiagnosticStatus>,
}
