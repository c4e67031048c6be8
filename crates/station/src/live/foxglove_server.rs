//! The recording's messages for Foxglove and Lichtblick while they are recorded: a WebSocket server on this
//! machine alone, in threads that a run without it does not have.

use std::net::SocketAddr;

use anyhow::{Context as _, Result, bail};
use barrelman_trial::records::LiveChannels;
use foxglove::WebSocketServer;

/// Starts a server, which runs until the program ends, and gives the channels that a recorder fills.
///
/// # Errors
/// The address is not of this machine alone, or is in use.
pub fn serve(address: SocketAddr) -> Result<LiveChannels> {
    if !address.ip().is_loopback() {
        bail!(
            "--foxglove {address}: the server asks nobody for a token, so that it listens on this machine alone. Give \
             127.0.0.1:{port}; from another machine, use ssh -L {port}:127.0.0.1:{port}",
            port = address.port()
        );
    }
    let channels = LiveChannels::new()?;
    let server = WebSocketServer::new()
        .name("barrelman")
        .bind(address.ip().to_string(), address.port())
        .context(channels.context())
        .start_blocking()
        .with_context(|| format!("--foxglove {address}"))?;
    tracing::info!("Foxglove: open a connection to ws://{}:{}", address.ip(), server.port());
    Ok(channels)
}
