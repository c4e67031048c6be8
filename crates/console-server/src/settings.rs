//! How a console is served: its address, its tokens, and what happens when the controlling page is gone.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use anyhow::{Context, Result, bail};

use barrelman_host::clock::Clock;
use barrelman_host::state_folder::state_folder;

use super::access::Access;
use super::entrance::Entrance;
use super::guard::Hosts;
use super::https::{CertificateFiles, Identity};
use super::issued_links::IssuedLinks;
use super::links::fingerprint;
use super::map::Map;
use super::on_lost::OnConsoleLost;
use super::origin::{Origin, Scheme};
use super::tokens::{KeptTokens, TokensInForce};

/// Ports that are tried where no address is given.
const PORTS: std::ops::Range<u16> = 8480..8490;

/// Name of the file with the own certificate authority.
const AUTHORITY: &str = "console-authority.json";

/// When a console is encrypted, and with which certificate.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Encryption {
    /// Off loopback, with a certificate of the program's own authority.
    #[default]
    OffLoopback,
    /// On loopback, too.
    Always,
    /// Always, with this certificate.
    Given(CertificateFiles),
    /// Never.
    Never,
}

/// Where a console is served.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ConsoleAddress {
    /// The address; `None`: the first free port of loopback from 8480 on.
    pub listen: Option<SocketAddr>,
    /// Further names that the server answers to, besides its addresses.
    pub host_names: Vec<String>,
    /// The encryption.
    pub encryption: Encryption,
}

/// How a console is served.
pub struct ConsoleSettings {
    /// The socket.
    pub listener: TcpListener,
    /// The tokens; without any, everybody who reaches the socket may control.
    pub tokens: TokensInForce,
    /// Where the tokens are kept.
    pub kept: KeptTokens,
    /// Where the links are written while the console is served; `None`: nowhere.
    pub links_file: Option<PathBuf>,
    /// Further names that the server answers to, besides its addresses.
    pub host_names: Vec<String>,
    /// The map under boat and marks; `None`: there is none.
    pub map: Option<Map>,
    /// What happens when the controlling page is gone.
    pub on_lost: OnConsoleLost,
    /// The certificate; `None`: the console is not encrypted.
    pub(super) https: Option<Arc<Identity>>,
}

impl ConsoleSettings {
    /// A console with these tokens.
    ///
    /// # Errors
    /// If the address is in use, or the tokens or the certificate cannot be read or made.
    pub fn with_tokens(address: ConsoleAddress, kept: KeptTokens) -> Result<Self> {
        Ok(Self { tokens: TokensInForce::new(Some(kept.take()?)), kept, ..Self::open(address)? })
    }

    /// The same, without tokens where only this machine can reach the console.
    ///
    /// # Errors
    /// As [`Self::with_tokens`].
    pub fn without_tokens_on_loopback(address: ConsoleAddress, kept: KeptTokens) -> Result<Self> {
        let is_loopback = address.listen.is_none_or(|address| address.ip().is_loopback());
        if is_loopback && kept == KeptTokens::default() {
            Self::open(address)
        } else {
            Self::with_tokens(address, kept)
        }
    }

    /// The same socket and tokens once more, for a page that comes before the console.
    ///
    /// # Errors
    /// If the system has no further file descriptor.
    pub fn duplicate(&self) -> std::io::Result<Self> {
        Ok(Self {
            listener: self.listener.try_clone()?,
            tokens: self.tokens.clone(),
            kept: self.kept.clone(),
            links_file: None,
            host_names: self.host_names.clone(),
            map: None,
            on_lost: self.on_lost,
            https: self.https.clone(),
        })
    }

    fn open(address: ConsoleAddress) -> Result<Self> {
        let ConsoleAddress { listen, host_names, encryption } = address;
        let listener = listener_at(listen)?;
        let https = identity(encryption, listener.local_addr()?.ip(), &host_names)?.map(Arc::new);
        Ok(Self {
            listener,
            tokens: TokensInForce::default(),
            kept: KeptTokens::default(),
            links_file: None,
            host_names,
            map: None,
            on_lost: OnConsoleLost::default(),
            https,
        })
    }

    /// How clients come in.
    ///
    /// # Errors
    /// If the socket has no address.
    pub(super) fn entrance(&self, clock: Clock) -> std::io::Result<Entrance> {
        let origin = self.origin()?;
        let own_names = self.https.iter().flat_map(|identity| identity.names());
        let names = self.host_names.iter().chain(own_names).cloned().collect();
        Ok(Entrance {
            access: Access::new(self.tokens.clone(), origin, clock),
            links: IssuedLinks::new(
                origin,
                fingerprint(self.https.as_deref()).map(str::to_owned),
                self.kept.clone(),
                self.links_file.clone(),
                clock.now(),
            ),
            hosts: Hosts::new(origin, names),
            https: self.https.clone(),
        })
    }

    /// Where the console is.
    pub(super) fn origin(&self) -> std::io::Result<Origin> {
        let scheme = if self.https.is_some() { Scheme::Https } else { Scheme::Http };
        Ok(Origin { scheme, address: self.listener.local_addr()? })
    }
}

/// The certificate of a console at this address; `None`: the console is not encrypted.
pub(super) fn identity(
    encryption: Encryption,
    address: IpAddr,
    host_names: &[String],
) -> Result<Option<Identity>> {
    match encryption {
        Encryption::Given(files) => Identity::given(&files).map(Some),
        Encryption::OffLoopback if address.is_loopback() => Ok(None),
        Encryption::OffLoopback | Encryption::Always => {
            let folder = state_folder().context(
                "there is no folder for the console's certificate authority: set HOME or XDG_STATE_HOME, or give \
                 --tls-certificate and --tls-key",
            )?;
            Identity::own(&folder.join(AUTHORITY), address, host_names, SystemTime::now()).map(Some)
        }
        Encryption::Never => {
            if !address.is_loopback() {
                tracing::warn!(
                    "THE CONSOLE IS NOT ENCRYPTED (--insecure): anyone who can read the network can read the token, and command the \
                     camera and the boat"
                );
            }
            Ok(None)
        }
    }
}

pub(super) fn listener_at(address: Option<SocketAddr>) -> Result<TcpListener> {
    if let Some(address) = address {
        return TcpListener::bind(address).with_context(|| {
            format!(
                "cannot listen on {address}: does another program use it? choose another address (--listen, or \
                 console.listen of the configuration)"
            )
        });
    }
    let loopback = |port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
    match PORTS.map(loopback).find_map(|address| TcpListener::bind(address).ok()) {
        Some(listener) => Ok(listener),
        None => {
            bail!("ports {} to {} of this machine are in use: give --listen ADDR", PORTS.start, PORTS.end - 1)
        }
    }
}
