//! The video that a vehicle names.

/// The main video of a vehicle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MainVideo {
    /// The stream's name.
    pub name: String,
    /// Its address: without encryption where there is one, otherwise in TLS (`rtsps://`); `None`: it has neither.
    pub address: Option<String>,
}
