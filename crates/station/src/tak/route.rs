//! How events go: what an address means on this machine.

use std::net::SocketAddr;

use super::line::Encryption;

/// How events go to an address that is resolved.
#[derive(Debug, Clone)]
pub enum TakRoute {
    /// A datagram for each event.
    Udp(SocketAddr),
    /// A connection, with TLS or without.
    Tcp(SocketAddr, Option<Encryption>),
}
