//! The messages of a share: a server from which programs of others read the annotated video.
//!
//! The standard output of the process is the socket that listens. The program keeps it open, so that readers
//! find the same port where the process is started again.

use serde::{Deserialize, Serialize};

/// The user that readers give, where a password is asked for.
pub const SHARE_USER: &str = "watch";

/// Largest number of readers at a time.
pub const MAX_READERS: usize = 8;

/// What is served, and to whom.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShareSettings {
    /// The path of the address, with its first slash.
    pub path: String,
    /// The password of [`SHARE_USER`]; `None`: everybody who reaches the port may read.
    pub password: Option<String>,
}

/// A message to a share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToShare {
    /// An H.264 access unit with start codes, which is the payload.
    Unit {
        /// Whether decoding can start here.
        key: bool,
    },
}

/// A message of a share.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum FromShare {
    /// The server serves. Sent once, first.
    Ready,
    /// The server cannot serve. The process ends.
    Failed {
        /// Why.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// What the readers need from now on. Sent at each change.
    Demand(Demand),
}

/// What the readers need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
pub enum Demand {
    /// Nobody reads.
    #[default]
    Nothing,
    /// Units.
    Units,
    /// Units from a key frame on: a reader waits for one.
    KeyFrame,
}

impl std::fmt::Debug for ShareSettings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ShareSettings({}, ***)", self.path)
    }
}
