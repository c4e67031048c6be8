//! The beginning of a connection to a server with HTTPS.

use std::io;
use std::time::SystemTime;

use barrelman_host::clock::Clock;
use tokio::net::TcpStream;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::server::TlsStream;

use super::identity::Identity;
use crate::limited_stream::{Bytes, LimitedStream};
use crate::limits::{BYTES, HANDSHAKE_TIMEOUT};

/// The first byte of a TLS connection: a record of the handshake (RFC 8446, section 5.1).
const HANDSHAKE: u8 = 22;

type Limited = LimitedStream<TcpStream, Bytes>;

/// A connection that has begun.
pub(crate) enum Accepted {
    /// Over TLS.
    Encrypted(Box<TlsStream<Limited>>),
    /// The client speaks HTTP without TLS.
    Plain(Limited),
}

/// Makes the handshake. What is read is counted and takes turns below TLS, so that a client that sends
/// records without content is limited, too.
///
/// # Errors
/// If the handshake fails, or does not end in time.
pub(crate) async fn accept(stream: TcpStream, identity: &Identity, clock: Clock) -> io::Result<Accepted> {
    let handshake = async {
        let mut first = [0];
        stream.peek(&mut first).await?;
        let reached = stream.local_addr()?.ip();
        let limited = LimitedStream::new(stream, Bytes, BYTES, clock);
        if first != [HANDSHAKE] {
            return Ok(Accepted::Plain(limited));
        }
        let config = identity.config_for(reached, SystemTime::now()).map_err(io::Error::other)?;
        Ok(Accepted::Encrypted(Box::new(TlsAcceptor::from(config).accept(limited).await?)))
    };
    tokio::time::timeout(HANDSHAKE_TIMEOUT, handshake).await?
}
