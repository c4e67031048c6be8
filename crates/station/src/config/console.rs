//! The console and the recordings in the configuration.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use barrelman_console_server::{CertificateFiles, ConsoleAddress, Encryption, KeptTokens, OnConsoleLost};

/// The operator's console.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ConsoleSection {
    /// Address of the console, an IP address with a port: "0.0.0.0:8480" is for other devices, too, over
    /// HTTPS; default: "127.0.0.1:8480", or the next free port.
    #[schemars(example = "127.0.0.1:8480")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub listen: Option<SocketAddr>,
    /// Further names by which the console is opened, besides the addresses of this machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hosts: Option<Vec<String>>,
    /// File with the console's tokens, two lines: control, watch. Where it is missing, tokens are made and
    /// kept in it; without this key, tokens are made for each run.
    #[schemars(example = "/etc/barrelman/console-tokens")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub token_file: Option<PathBuf>,
    /// Age at which the tokens of the file are renewed, hours; without it, they stay.
    #[schemars(range(min = 0.001, max = 100_000.0), example = 720.0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub token_ttl_h: Option<f64>,
    /// Map under boat and marks: a folder of tiles ZOOM/X/Y.png, or an MBTiles file.
    #[schemars(example = "/var/lib/barrelman/harbour.mbtiles")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<PathBuf>,
    /// What happens when the controlling page is gone: closed for 2 s, or silent for 3 s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_lost: Option<OnConsoleLost>,
    /// Certificate for HTTPS (PEM, with those of the authorities above it); without it, the program's own
    /// authority issues one.
    #[schemars(example = "/etc/barrelman/console.pem")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tls_certificate: Option<PathBuf>,
    /// Key of the certificate (PEM).
    #[schemars(example = "/etc/barrelman/console-key.pem")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tls_key: Option<PathBuf>,
    /// Whether the console is served over HTTPS on loopback, too. Off loopback HTTPS is the default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tls_on_loopback: Option<bool>,
    /// Whether the console is served over HTTP off loopback: anyone who can read the network can read the
    /// token, and command camera and boat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub insecure: Option<bool>,
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
    /// Where the console is served.
    pub address: ConsoleAddress,
    /// Where the tokens are kept.
    pub tokens: KeptTokens,
    /// The map; `None`: there is none.
    pub map: Option<PathBuf>,
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
    ///
    /// # Errors
    /// If keys of the encryption exclude each other.
    pub(super) fn resolve(&self) -> Result<ConsoleConfig> {
        Ok(ConsoleConfig {
            address: ConsoleAddress {
                listen: self.listen,
                host_names: self.hosts.clone().unwrap_or_default(),
                encryption: self.encryption()?,
            },
            tokens: KeptTokens {
                file: self.token_file.clone(),
                max_age: self.token_ttl_h.map(|hours| Duration::from_secs_f64(3600.0 * hours)),
            },
            map: self.map.clone(),
            on_lost: self.on_lost.unwrap_or_default(),
        })
    }

    fn encryption(&self) -> Result<Encryption> {
        let is_asked_for = self.tls_certificate.is_some() || self.tls_on_loopback == Some(true);
        if self.insecure == Some(true) {
            ensure!(
                !is_asked_for,
                "console.insecure excludes console.tls_certificate and console.tls_on_loopback"
            );
            return Ok(Encryption::Never);
        }
        Ok(match (&self.tls_certificate, &self.tls_key) {
            (Some(certificate), Some(key)) => {
                Encryption::Given(CertificateFiles { certificate: certificate.clone(), key: key.clone() })
            }
            (None, None) if self.tls_on_loopback == Some(true) => Encryption::Always,
            (None, None) => Encryption::OffLoopback,
            _ => bail!("console.tls_certificate and console.tls_key belong together: give both, or neither"),
        })
    }

    /// A complete section.
    pub(super) fn from_config(config: &ConsoleConfig) -> Self {
        let ConsoleAddress { listen, host_names, encryption } = config.address.clone();
        let (tls_on_loopback, insecure) = (encryption == Encryption::Always, encryption == Encryption::Never);
        let files = match encryption {
            Encryption::Given(files) => Some(files),
            Encryption::OffLoopback | Encryption::Always | Encryption::Never => None,
        };
        let (tls_certificate, tls_key) = files.map(|files| (files.certificate, files.key)).unzip();
        Self {
            listen,
            hosts: Some(host_names),
            token_file: config.tokens.file.clone(),
            token_ttl_h: config.tokens.max_age.map(|max_age| max_age.as_secs_f64() / 3600.0),
            map: config.map.clone(),
            on_lost: Some(config.on_lost),
            tls_certificate,
            tls_key,
            tls_on_loopback: Some(tls_on_loopback),
            insecure: Some(insecure),
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
