//! The console and the recordings in the configuration.

use std::net::SocketAddr;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use barrelman_console_server::OnConsoleLost;

/// The operator's console.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ConsoleSection {
    /// Address of the console, an IP address with a port: "0.0.0.0:8480" is for other devices, too, without encryption; default:
    /// "127.0.0.1:8480", or the next free port.
    #[schemars(example = "127.0.0.1:8480")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub listen: Option<SocketAddr>,
    /// Further names by which the console is opened, besides the addresses of this machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hosts: Option<Vec<String>>,
    /// File with the console's tokens, two lines: control, watch. Where it is missing, tokens are made and kept in it; without this
    /// key, tokens are made for each run.
    #[schemars(example = "/etc/barrelman/console-tokens")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub token_file: Option<PathBuf>,
    /// What happens when the controlling page is gone: closed for 2 s, or silent for 3 s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_lost: Option<OnConsoleLost>,
}

/// The recordings that `run` makes without being asked.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RecordingSection {
    /// Whether `run` records without `--record`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub enabled: Option<bool>,
    /// The folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folder: Option<PathBuf>,
    /// Size of all recordings in the folder, gigabytes. The oldest make room for a new one.
    #[schemars(range(min = 0.1, max = 100_000.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quota_gb: Option<f64>,
    /// Free space of the disk that a recording leaves, gigabytes.
    #[schemars(range(min = 0.0, max = 100_000.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reserve_gb: Option<f64>,
}

/// The effective settings of the console.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ConsoleConfig {
    /// The address; `None`: the first free port.
    pub listen: Option<SocketAddr>,
    /// Further names of the server.
    pub hosts: Vec<String>,
    /// The file with the tokens; `None`: tokens are made.
    pub token_file: Option<PathBuf>,
    /// What happens when the controlling page is gone.
    pub on_lost: OnConsoleLost,
}

/// The effective settings of recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingConfig {
    /// Whether `run` records without `--record`.
    pub enabled: bool,
    /// The folder.
    pub folder: PathBuf,
    /// Size of all recordings in the folder, gigabytes.
    pub quota_gb: f64,
    /// Free space that a recording leaves, gigabytes.
    pub reserve_gb: f64,
}

impl ConsoleSection {
    /// The effective settings.
    pub(super) fn resolve(&self) -> ConsoleConfig {
        ConsoleConfig {
            listen: self.listen,
            hosts: self.hosts.clone().unwrap_or_default(),
            token_file: self.token_file.clone(),
            on_lost: self.on_lost.unwrap_or_default(),
        }
    }

    /// A complete section.
    pub(super) fn from_config(config: &ConsoleConfig) -> Self {
        Self {
            listen: config.listen,
            hosts: Some(config.hosts.clone()),
            token_file: config.token_file.clone(),
            on_lost: Some(config.on_lost),
        }
    }
}

impl Default for RecordingConfig {
    fn default() -> Self {
        RecordingSection::default().resolve()
    }
}

impl RecordingSection {
    /// The effective settings.
    pub(super) fn resolve(&self) -> RecordingConfig {
        RecordingConfig {
            enabled: self.enabled.unwrap_or(true),
            folder: self.folder.clone().unwrap_or_else(|| PathBuf::from("recordings")),
            quota_gb: self.quota_gb.unwrap_or(20.0),
            reserve_gb: self.reserve_gb.unwrap_or(2.0),
        }
    }

    /// A complete section.
    pub(super) fn from_config(config: &RecordingConfig) -> Self {
        Self {
            enabled: Some(config.enabled),
            folder: Some(config.folder.clone()),
            quota_gb: Some(config.quota_gb),
            reserve_gb: Some(config.reserve_gb),
        }
    }
}
