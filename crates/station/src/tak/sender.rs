//! Events on their way: datagrams, or a connection that is made again.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::time::Duration;

use barrelman_vocab::Timestamp;

use super::line::{Encryption, Line};
use super::route::TakRoute;
use super::send_log::Sent;

/// Pauses between attempts to connect: the first, which doubles up to the last.
const PAUSES: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(30));

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
    pub(super) fn open(route: TakRoute) -> io::Result<Self> {
        Ok(match route {
            TakRoute::Udp(to) => Self::Udp { socket: datagram_socket(to)?, to },
            TakRoute::Tcp(to, encryption) => {
                Self::Tcp(Connection { to, encryption, line: None, pause: PAUSES.0, retry: None })
            }
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
    encryption: Option<Encryption>,
    line: Option<Line>,
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
                self.line = None;
                self.retry = Some((now.plus(self.pause), error.to_string()));
                self.pause = (self.pause * 2).min(PAUSES.1);
                // Some of them may have arrived.
                Sent { lost: all, failure: Some(error.to_string()) }
            }
        }
    }

    fn try_send(&mut self, events: &[Vec<u8>]) -> io::Result<()> {
        let mut line = match self.line.take() {
            Some(line) => line,
            None => Line::connect(self.to, self.encryption.as_ref())?,
        };
        line.drop_received()?;
        line.send(&events.concat())?;
        self.line = Some(line);
        Ok(())
    }
}

/// Whether events can be sent on a route: the own address from which they would go. A datagram is not sent.
///
/// # Errors
/// If there is no way there, or nobody takes the connection.
pub fn probe(route: &TakRoute) -> io::Result<IpAddr> {
    let own = match route {
        TakRoute::Udp(to) => {
            let socket = datagram_socket(*to)?;
            socket.connect(to)?;
            socket.local_addr()?
        }
        TakRoute::Tcp(to, encryption) => {
            let mut line = Line::connect(*to, encryption.as_ref())?;
            line.wait_for_refusal()?;
            line.socket().local_addr()?
        }
    };
    Ok(own.ip())
}

#[cfg(test)]
mod tests;
