//! A TCP connection to the host of an address, and why there is none.

use std::io;
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use barrelman_media_protocol::failure::SourceFailure;
use url::Url;

use super::failure::{from_words, temporary};

/// Longest wait for a connection.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Connects to the host of an address, at its port or at this one.
pub(super) fn connect(url: &Url, port: u16) -> io::Result<TcpStream> {
    let host = url.host_str().unwrap_or_default().trim_matches(['[', ']']);
    // The system has no kind of error for a name that is not known.
    let unknown = || io::Error::from(io::ErrorKind::NotFound);
    let mut last = unknown();
    for address in (host, url.port().unwrap_or(port)).to_socket_addrs().map_err(|_| unknown())? {
        match TcpStream::connect_timeout(&address, TIMEOUT) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Why there is no connection.
pub(super) fn unreachable(error: &io::Error) -> SourceFailure {
    let words = match error.kind() {
        io::ErrorKind::NotFound => "unknown host",
        io::ErrorKind::ConnectionRefused => "connection refused",
        io::ErrorKind::HostUnreachable | io::ErrorKind::NetworkUnreachable => "no route",
        io::ErrorKind::TimedOut => "timed out",
        _ => "",
    };
    from_words(words).unwrap_or_else(|| temporary(format!("cannot be reached: {error}"), ""))
}
