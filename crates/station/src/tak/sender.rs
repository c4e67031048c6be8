//! Events on their way: datagrams, or a connection that is made again.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpStream, UdpSocket};
use std::time::Duration;

use barrelman_vocab::Timestamp;

use super::address::Transport;
use super::send_log::Sent;

/// How long a connection may take to be made.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);
/// A server that takes nothing for this long is given up.
const WRITE_TIMEOUT: Duration = Duration::from_secs(1);
/// Pauses between attempts to connect: the first, which doubles up to the last.
const PAUSES: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(30));
/// Most bytes that are read and dropped at a time: a server sends the events of all others.
const MOST_READ: usize = 1 << 20;

/// Where events go.
#[derive(Debug)]
pub(super) enum Sender {
    Udp { socket: UdpSocket, to: SocketAddr },
    Tcp(Connection),
}

impl Sender {
    /// Opens the way. A connection is made with the first events.
    ///
    /// # Errors
    /// If the system gives no socket.
    pub(super) fn open(transport: Transport, to: SocketAddr) -> io::Result<Self> {
        Ok(match transport {
            Transport::Udp => Self::Udp { socket: datagram_socket(to)?, to },
            Transport::Tcp => Self::Tcp(Connection { to, stream: None, pause: PAUSES.0, retry: None }),
        })
    }

    /// Sends events. Of a datagram that nobody receives nothing is known.
    pub(super) fn send(&mut self, events: &[Vec<u8>], now: Timestamp) -> Sent {
        match self {
            Self::Udp { socket, to } => {
                let failures = events.iter().filter_map(|event| socket.send_to(event, *to).err());
                let failures: Vec<_> = failures.map(|error| error.to_string()).collect();
                Sent { lost: failures.len() as u64, failure: failures.into_iter().next() }
            }
            Self::Tcp(connection) => connection.send(events, now),
        }
    }
}

/// A socket that never waits. Events for a group stay in the network of the sender: their time to live is 1.
fn datagram_socket(to: SocketAddr) -> io::Result<UdpSocket> {
    let any: IpAddr = if to.is_ipv4() { Ipv4Addr::UNSPECIFIED.into() } else { Ipv6Addr::UNSPECIFIED.into() };
    let socket = UdpSocket::bind((any, 0))?;
    socket.set_nonblocking(true)?;
    if to.is_ipv4() {
        socket.set_multicast_ttl_v4(1)?;
    }
    Ok(socket)
}

/// A connection to a server.
#[derive(Debug)]
pub(super) struct Connection {
    to: SocketAddr,
    stream: Option<TcpStream>,
    pause: Duration,
    /// When the next attempt is due, and why the last one failed.
    retry: Option<(Timestamp, String)>,
}

impl Connection {
    fn send(&mut self, events: &[Vec<u8>], now: Timestamp) -> Sent {
        let all = events.len() as u64;
        if let Some((_, failure)) = self.retry.as_ref().filter(|(due, _)| now < *due) {
            return Sent { lost: all, failure: Some(failure.clone()) };
        }
        match self.try_send(events) {
            Ok(()) => {
                (self.pause, self.retry) = (PAUSES.0, None);
                Sent { lost: 0, failure: None }
            }
            Err(error) => {
                self.stream = None;
                self.retry = Some((now.plus(self.pause), error.to_string()));
                self.pause = (self.pause * 2).min(PAUSES.1);
                // Some of them may have arrived.
                Sent { lost: all, failure: Some(error.to_string()) }
            }
        }
    }

    fn try_send(&mut self, events: &[Vec<u8>]) -> io::Result<()> {
        let stream = match self.stream.take() {
            Some(stream) => stream,
            None => connected(self.to)?,
        };
        drop_received(&stream)?;
        (&stream).write_all(&events.concat())?;
        self.stream = Some(stream);
        Ok(())
    }
}

fn connected(to: SocketAddr) -> io::Result<TcpStream> {
    let stream = TcpStream::connect_timeout(&to, CONNECT_TIMEOUT)?;
    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

/// Reads what the server sent, so that it need not wait.
///
/// # Errors
/// If the server has closed the connection.
fn drop_received(mut stream: &TcpStream) -> io::Result<()> {
    stream.set_nonblocking(true)?;
    let mut buffer = [0; 16_384];
    let mut read = 0;
    while read < MOST_READ {
        match stream.read(&mut buffer) {
            Ok(0) => {
                return Err(io::Error::new(ErrorKind::ConnectionAborted, "the server closed the connection"));
            }
            Ok(bytes) => read += bytes,
            Err(error) if error.kind() == ErrorKind::WouldBlock => break,
            Err(error) => return Err(error),
        }
    }
    stream.set_nonblocking(false)
}

/// Whether events can be sent to an address: the own address from which they would go. A datagram is not sent.
///
/// # Errors
/// If there is no way there, or nobody takes the connection.
pub fn probe(transport: Transport, to: SocketAddr) -> io::Result<IpAddr> {
    let own = match transport {
        Transport::Udp => {
            let socket = datagram_socket(to)?;
            socket.connect(to)?;
            socket.local_addr()?
        }
        Transport::Tcp => connected(to)?.local_addr()?,
    };
    Ok(own.ip())
}

#[cfg(test)]
mod tests;
