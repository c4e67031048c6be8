//! Options of the console, for `run` and `demo`.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Result;
use barrelman_console_server::{
    CertificateFiles, ConsoleAddress, Encryption, KeptTokens, Map, OnConsoleLost,
};
use clap::Args;

use super::values::{parse_hours, parse_listen};

/// Options of the console.
#[derive(Debug, Clone, Args, Default)]
pub struct ConsoleOptions {
    /// Address of the console; default: 127.0.0.1:8480, or the next free port.
    #[arg(long, value_name = "ADDR", value_parser = parse_listen)]
    pub listen: Option<SocketAddr>,
    /// File with the console's tokens, two lines: control, watch; where it is missing, tokens are made and
    /// kept in it. Without this option, tokens are made for this run and printed as links.
    #[arg(long, value_name = "FILE")]
    pub console_token_file: Option<PathBuf>,
    /// Renew the tokens of the file when they are so old, hours: links that were not opened by then open
    /// nothing. Pages that are open stay.
    #[arg(long, value_name = "HOURS", value_parser = parse_hours)]
    pub token_ttl: Option<f64>,
    /// Show this map under boat and marks, where latitude and longitude are known: a folder of tiles
    /// ZOOM/X/Y.png, or an MBTiles file. Nothing is fetched.
    #[arg(long, value_name = "PATH")]
    pub map: Option<PathBuf>,
    /// What happens when the controlling page is gone (closed for 2 s, or silent for 3 s): the camera goes
    /// on, or stops.
    #[arg(long, value_enum, value_name = "WHAT")]
    pub on_console_lost: Option<OnConsoleLost>,
    /// Serve HTTPS with this certificate (PEM, with those of the authorities above it), instead of one of the
    /// program's own authority.
    #[arg(long, value_name = "FILE.pem", requires = "tls_key", conflicts_with = "insecure")]
    pub tls_certificate: Option<PathBuf>,
    /// Key of the certificate (PEM).
    #[arg(long, value_name = "FILE.pem", requires = "tls_certificate")]
    pub tls_key: Option<PathBuf>,
    /// Serve HTTPS on loopback, too, and Foxglove there for a token. Off loopback that is the default.
    #[arg(long, conflicts_with = "insecure")]
    pub tls_on_loopback: bool,
    /// Serve HTTP off loopback: anyone who can read the network can read the token, and command camera and
    /// boat.
    #[arg(long)]
    pub insecure: bool,
}

impl ConsoleOptions {
    /// The encryption that the options ask for.
    fn encryption(&self) -> Option<Encryption> {
        match (&self.tls_certificate, &self.tls_key) {
            _ if self.insecure => Some(Encryption::Never),
            (Some(certificate), Some(key)) => Some(Encryption::Given(CertificateFiles {
                certificate: certificate.clone(),
                key: key.clone(),
            })),
            _ if self.tls_on_loopback => Some(Encryption::Always),
            _ => None,
        }
    }

    /// The map, or that of the configuration.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn open_map(&self, configured: Option<&Path>) -> Result<Option<Map>> {
        self.map.as_deref().or(configured).map(Map::open).transpose()
    }

    /// Where the tokens are kept, with what the configuration says where there is no option.
    pub fn kept_tokens(&self, configured: KeptTokens) -> KeptTokens {
        let max_age = self.token_ttl.map(|hours| Duration::from_secs_f64(3600.0 * hours));
        KeptTokens {
            file: self.console_token_file.clone().or(configured.file),
            max_age: max_age.or(configured.max_age),
        }
    }

    /// Where the console is served, with what the configuration says where there is no option.
    pub fn address(&self, configured: ConsoleAddress) -> ConsoleAddress {
        let encryption = match (self.encryption(), configured.encryption) {
            // A certificate of the configuration is for loopback, too.
            (None | Some(Encryption::Always), given @ Encryption::Given(_)) => given,
            (option, configured) => option.unwrap_or(configured),
        };
        let listen = self.listen.or(configured.listen);
        ConsoleAddress { listen, encryption, host_names: configured.host_names }
    }
}
