//! How a console is served: its address, its tokens, and what happens when the controlling page is gone.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::access::Tokens;
use super::on_lost::OnConsoleLost;

/// Ports that are tried where no address is given.
const PORTS: std::ops::Range<u16> = 8480..8490;

/// How a console is served.
pub struct ConsoleSettings {
    /// The socket.
    pub listener: TcpListener,
    /// The tokens; `None`: everybody who reaches the socket may control.
    pub tokens: Option<Tokens>,
    /// The file that the tokens are from; `None`: they were made for this program's life.
    pub token_file: Option<PathBuf>,
    /// Where the links are written while the console is served; `None`: nowhere.
    pub links_file: Option<PathBuf>,
    /// Further names that the server answers to, besides its addresses.
    pub host_names: Vec<String>,
    /// What happens when the controlling page is gone.
    pub on_lost: OnConsoleLost,
}

impl ConsoleSettings {
    /// A console at `address`, or at the first free port of loopback from 8480 on. `token_file`: two lines, control and
    /// watch, made where the file is missing; without it, tokens are made for this program's life.
    ///
    /// # Errors
    /// If the address is in use, or the tokens cannot be read or made.
    pub fn with_tokens(address: Option<SocketAddr>, token_file: Option<&Path>) -> Result<Self> {
        let tokens = match token_file {
            Some(path) => Tokens::kept_in(path)?,
            None => Tokens::random().context("no random numbers for the console's tokens")?,
        };
        let token_file = token_file.map(Path::to_owned);
        Ok(Self { tokens: Some(tokens), token_file, ..Self::open(address)? })
    }

    /// The same, without tokens where only this machine can reach the console.
    ///
    /// # Errors
    /// As [`Self::with_tokens`].
    pub fn without_tokens_on_loopback(
        address: Option<SocketAddr>,
        token_file: Option<&Path>,
    ) -> Result<Self> {
        let is_loopback = address.is_none_or(|address| address.ip().is_loopback());
        if is_loopback && token_file.is_none() {
            Self::open(address)
        } else {
            Self::with_tokens(address, token_file)
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
            token_file: self.token_file.clone(),
            links_file: None,
            host_names: self.host_names.clone(),
            on_lost: self.on_lost,
        })
    }

    fn open(address: Option<SocketAddr>) -> Result<Self> {
        Ok(Self {
            listener: listen(address)?,
            tokens: None,
            token_file: None,
            links_file: None,
            host_names: Vec::new(),
            on_lost: OnConsoleLost::default(),
        })
    }
}

fn listen(address: Option<SocketAddr>) -> Result<TcpListener> {
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
