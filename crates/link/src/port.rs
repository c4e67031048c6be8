//! Ports that carry bytes: a serial port, a TCP connection, or UDP datagrams. Every wait is bounded.
//!
//! A serial port is locked twice, so that no other program writes to it: `flock` keeps out programs that
//! request the lock, including root's, and `TIOCEXCL` keeps out programs that do not. Lock files are not
//! used: they outlive the programs that made them.

use std::io::{self, Read as _, Write as _};
use std::net::{Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpStream, ToSocketAddrs as _, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::FlockOperation;
use rustix::net::sockopt;
use serial2::SerialPort;

use crate::url::Endpoint;

/// Longest time of a write. The port then counts as lost. It is less than the silence after which a guard
/// counts as hung.
const WRITE_TIMEOUT: Duration = Duration::from_millis(100);
/// Longest time of a connection attempt.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(1);

/// Time without traffic until a TCP connection is probed, and between the probes.
const KEEPALIVE_INTERVAL: Duration = Duration::from_secs(1);
/// Number of unanswered probes after which a TCP connection is lost.
const KEEPALIVE_PROBES: u32 = 3;
/// Longest time that sent bytes of a TCP connection may remain unacknowledged, ms.
const UNACKNOWLEDGED_MS: u32 = 3_000;

/// A port cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The device does not exist.
    #[error("the port {} does not exist: is the ground station plugged in and on? `ls /dev/ttyACM* /dev/ttyUSB*` lists what is there", path.display())]
    Missing {
        /// The device.
        path: PathBuf,
    },
    /// The user may not open the device.
    #[error(
        "the port {} may not be opened by this user: add the user to its group (`sudo usermod -aG dialout $USER`, \
         then log in again), or install config/udev/70-barrelman.rules", path.display()
    )]
    NotAllowed {
        /// The device.
        path: PathBuf,
    },
    /// Another program uses the device.
    #[error(
        "the port {} is in use by another program: `fuser -v {}` names it; ModemManager is kept out by \
         config/udev/70-barrelman.rules", path.display(), path.display()
    )]
    InUse {
        /// The device.
        path: PathBuf,
    },
    /// The file is not a serial port.
    #[error("{} is not a serial port: give the device, as in serial:/dev/ttyACM0 (`ls /dev/ttyACM* /dev/ttyUSB*` lists them)", path.display())]
    NotSerial {
        /// The file.
        path: PathBuf,
    },
    /// The address refuses connections, or does not answer.
    #[error(
        "{address} cannot be reached: is the vehicle, or the pass-through server on the ground computer, running?"
    )]
    Unreachable {
        /// `host:port`.
        address: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The address is that of a simulated camera, which has no port.
    #[error("sim: has no port: it moves the camera of the world of --video sim:SCENARIO")]
    Simulated,
    /// The vehicle at an address of HTTP cannot be used.
    #[error("{address} is not usable: {reason}")]
    NotUsable {
        /// The base address.
        address: String,
        /// The reason, and the remedy.
        reason: String,
    },
    /// The device cannot be opened for another reason.
    #[error("the port {} cannot be opened", path.display())]
    Other {
        /// The device.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

impl PortError {
    /// Whether the vehicle may just not be there yet: its device is not plugged in, or nobody answers. Every
    /// other error stays until somebody corrects it.
    pub const fn may_pass(&self) -> bool {
        match self {
            Self::Missing { .. } | Self::Unreachable { .. } => true,
            Self::NotAllowed { .. }
            | Self::InUse { .. }
            | Self::NotSerial { .. }
            | Self::Simulated
            | Self::NotUsable { .. }
            | Self::Other { .. } => false,
        }
    }
}

/// An open port.
#[derive(Debug)]
pub enum Port {
    /// A serial port, locked.
    Serial(SerialPort),
    /// A TCP connection.
    Tcp(TcpStream),
    /// Datagrams from and to one address.
    Udp(UdpSocket),
}

impl Port {
    /// Opens a port.
    ///
    /// # Errors
    /// [`PortError`] names the port and the remedy.
    pub fn open(endpoint: &Endpoint) -> Result<Self, PortError> {
        match endpoint {
            Endpoint::Serial { path, baud } => open_serial(path, *baud).map(Self::Serial),
            Endpoint::SimulatedCamera => Err(PortError::Simulated),
            Endpoint::Http(address) => Err(PortError::NotUsable {
                address: address.to_string(),
                reason: "this vehicle is not asked over HTTP: --profile fotokite-sigma is".to_owned(),
            }),
            Endpoint::Tcp { address } => connect(address)
                .map(Self::Tcp)
                .map_err(|source| PortError::Unreachable { address: address.clone(), source }),
            Endpoint::Udp { address } => connect_datagrams(address)
                .map(Self::Udp)
                .map_err(|source| PortError::Unreachable { address: address.clone(), source }),
        }
    }

    /// Writes all bytes, or fails within a bounded time. Bytes that are written at once are one datagram.
    ///
    /// # Errors
    /// If the port does not accept the bytes in time, or is lost.
    pub fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Serial(port) => port.write_all(bytes),
            Self::Tcp(stream) => stream.write_all(bytes),
            Self::Udp(socket) => socket.send(bytes).map(drop),
        }
    }

    /// Reads the bytes that have arrived, after `poll` has reported the port as readable.
    ///
    /// # Errors
    /// If the port is lost. A connection that the other end has closed is an error too.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = match self {
            Self::Serial(port) => port.read(buffer),
            Self::Tcp(stream) => stream.read(buffer),
            Self::Udp(socket) => socket.recv(buffer),
        };
        match read {
            Ok(0) if matches!(self, Self::Udp(_)) => Ok(0),
            Ok(0) => {
                Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the other end has closed the connection"))
            }
            Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) => {
                Ok(0)
            }
            other => other,
        }
    }

    /// Tells the other end of a connection that nothing more is sent. Returns whether that was done.
    pub fn end_sending(&mut self) -> bool {
        match self {
            Self::Tcp(stream) => stream.shutdown(Shutdown::Write).is_ok(),
            Self::Serial(_) | Self::Udp(_) => false,
        }
    }
}

impl AsFd for Port {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Serial(port) => port.as_fd(),
            Self::Tcp(stream) => stream.as_fd(),
            Self::Udp(socket) => socket.as_fd(),
        }
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        if let Self::Serial(port) = self {
            // The exclusive mode belongs to the device. It would outlive this program where another program
            // still has the device open. For a lost port the call fails without consequence.
            let _ = rustix::termios::ioctl_tiocnxcl(port.as_fd());
        }
    }
}

fn open_serial(path: &Path, baud: u32) -> Result<SerialPort, PortError> {
    let path_buf = || path.to_path_buf();
    let explain = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => PortError::Missing { path: path_buf() },
        io::ErrorKind::PermissionDenied => PortError::NotAllowed { path: path_buf() },
        io::ErrorKind::ResourceBusy => PortError::InUse { path: path_buf() },
        _ => PortError::Other { path: path_buf(), source },
    };
    // On a folder or a plain file, the terminal settings would fail with a misleading message.
    let kind = std::fs::metadata(path).map_err(explain)?;
    if kind.is_dir() || kind.is_file() {
        return Err(PortError::NotSerial { path: path_buf() });
    }
    let mut port = SerialPort::open(path, baud).map_err(|source| match source.raw_os_error() {
        Some(code) if code == rustix::io::Errno::NOTTY.raw_os_error() => {
            PortError::NotSerial { path: path_buf() }
        }
        _ => explain(source),
    })?;
    rustix::fs::flock(port.as_fd(), FlockOperation::NonBlockingLockExclusive).map_err(|error| {
        if error == rustix::io::Errno::WOULDBLOCK {
            PortError::InUse { path: path_buf() }
        } else {
            PortError::Other { path: path_buf(), source: error.into() }
        }
    })?;
    rustix::termios::ioctl_tiocexcl(port.as_fd()).map_err(|error| explain(error.into()))?;
    port.set_write_timeout(WRITE_TIMEOUT).map_err(explain)?;
    port.set_read_timeout(Duration::from_millis(1)).map_err(explain)?;
    Ok(port)
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for candidate in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&candidate, CONNECT_TIMEOUT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
                stream.set_nonblocking(false)?;
                watch_connection(&stream)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Makes a peer that is gone without a word an error within seconds, whether or not something waits to be
/// sent.
fn watch_connection(stream: &TcpStream) -> io::Result<()> {
    sockopt::set_socket_keepalive(stream, true)?;
    sockopt::set_tcp_keepidle(stream, KEEPALIVE_INTERVAL)?;
    sockopt::set_tcp_keepintvl(stream, KEEPALIVE_INTERVAL)?;
    sockopt::set_tcp_keepcnt(stream, KEEPALIVE_PROBES)?;
    sockopt::set_tcp_user_timeout(stream, UNACKNOWLEDGED_MS)?;
    Ok(())
}

/// A socket that exchanges datagrams with `address` alone. Nothing is sent yet, so that an address without a
/// listener is noticed by the first datagram at the earliest.
fn connect_datagrams(address: &str) -> io::Result<UdpSocket> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for candidate in address.to_socket_addrs()? {
        let any = match candidate {
            SocketAddr::V4(_) => SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0)),
            SocketAddr::V6(_) => SocketAddr::from((Ipv6Addr::UNSPECIFIED, 0)),
        };
        let open = || {
            let socket = UdpSocket::bind(any)?;
            socket.connect(candidate)?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        match open() {
            Ok(socket) => return Ok(socket),
            Err(error) => last = error,
        }
    }
    Err(last)
}

#[cfg(test)]
mod tests {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    use super::*;

    /// The next bytes that arrive at the port.
    fn received(port: &mut Port) -> io::Result<Vec<u8>> {
        let timeout = Timespec { tv_sec: 10, tv_nsec: 0 };
        let mut buffer = [0; 64];
        loop {
            let ready = poll(&mut [PollFd::new(&*port, PollFlags::IN)], Some(&timeout)).unwrap();
            assert_eq!(ready, 1, "nothing arrived");
            let read = port.read(&mut buffer)?;
            if read > 0 {
                return Ok(buffer[..read].to_vec());
            }
        }
    }

    #[test]
    fn a_udp_port_exchanges_datagrams_with_its_address_alone() {
        let vehicle = UdpSocket::bind("127.0.0.1:0").unwrap();
        let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
        let address = vehicle.local_addr().unwrap().to_string();
        let mut port = Port::open(&Endpoint::Udp { address }).unwrap();
        port.write_all(b"one").unwrap();
        port.write_all(b"two").unwrap();
        let mut buffer = [0; 64];
        let (read, from) = vehicle.recv_from(&mut buffer).unwrap();
        assert_eq!(&buffer[..read], b"one");
        assert_eq!(vehicle.recv(&mut buffer).unwrap(), 3);
        stranger.send_to(b"stop it", from).unwrap();
        vehicle.send_to(b"", from).unwrap();
        vehicle.send_to(b"answer", from).unwrap();
        assert_eq!(received(&mut port).unwrap(), b"answer", "an empty datagram does not end the port");
        assert_eq!(port.read(&mut buffer).unwrap(), 0, "a read does not block");
    }

    #[test]
    fn a_udp_port_without_a_listener_is_lost() {
        let nobody = UdpSocket::bind("127.0.0.1:0").unwrap();
        let address = nobody.local_addr().unwrap().to_string();
        drop(nobody);
        let mut port = Port::open(&Endpoint::Udp { address }).unwrap();
        let lost = port.write_all(b"anybody?").and_then(|()| received(&mut port));
        assert_eq!(lost.unwrap_err().kind(), io::ErrorKind::ConnectionRefused);
    }
}
