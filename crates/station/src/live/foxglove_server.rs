//! The recording's messages for Foxglove and Lichtblick while they are recorded: a WebSocket server on this
//! machine, in threads that a run without it does not have. Other devices come through a door that wants a
//! token.

use std::net::{Ipv4Addr, SocketAddr};

use anyhow::{Context as _, Result};
use barrelman_console_server::TokenDoor;
use barrelman_trial::records::LiveChannels;
use foxglove::WebSocketServer;

/// Where Foxglove reads.
pub enum FoxgloveEntrance {
    /// On this machine alone, at this address.
    Loopback(SocketAddr),
    /// Through a door.
    Door(TokenDoor),
}

impl FoxgloveEntrance {
    /// Starts a server, which runs until the program ends, and gives the channels that a recorder fills.
    ///
    /// # Errors
    /// The address is in use.
    pub fn serve(self) -> Result<LiveChannels> {
        let loopback = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let at = match &self {
            Self::Loopback(address) => *address,
            Self::Door(_) => loopback,
        };
        let channels = LiveChannels::new()?;
        let server = WebSocketServer::new()
            .name("barrelman")
            .bind(at.ip().to_string(), at.port())
            .context(channels.context())
            .start_blocking()
            .with_context(|| format!("--foxglove {at}"))?;
        match self {
            Self::Loopback(_) => {
                tracing::info!("Foxglove: open a connection to ws://{}:{}", at.ip(), server.port());
            }
            Self::Door(door) => {
                let url = door.url();
                door.lead_to(SocketAddr::new(at.ip(), server.port()), "foxglove")?;
                tracing::info!(
                    "Foxglove: open a connection to {url}/?token=TOKEN, where TOKEN is the console's watch token"
                );
            }
        }
        Ok(channels)
    }
}
