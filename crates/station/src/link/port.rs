//! Ports: a serial port or a TCP connection. Every wait is bounded.
//!
//! A serial port is locked twice, so that no other program writes to it: `flock` keeps out programs that request the
//! lock, including root's, and `TIOCEXCL` keeps out programs that do not. Lock files are not used: they outlive the
//! programs that made them.

use std::io::{self, Read as _, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::os::fd::{AsFd, BorrowedFd};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::FlockOperation;
use serial2::SerialPort;

use super::url::Endpoint;

/// Longest time of a write. The port then counts as lost.
const WRITE_TIMEOUT: Duration = Duration::from_millis(500);
/// Longest time of a connection attempt.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(1);

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
    #[error("{address} cannot be reached: is the pass-through server on the ground computer running?")]
    Unreachable {
        /// `host:port`.
        address: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The address is that of a simulated camera, which has no port.
    #[error("sim: has no port: it moves the camera of the world of --video sim:SCENARIO")]
    Simulated,
    /// The device cannot be opened for another reason.
    #[error("the port {} cannot be opened", path.display())]
    Other {
        /// The device.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// An open port.
#[derive(Debug)]
pub enum Port {
    /// A serial port, locked.
    Serial(SerialPort),
    /// A TCP connection.
    Tcp(TcpStream),
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
            Endpoint::Tcp { address } => connect(address)
                .map(Self::Tcp)
                .map_err(|source| PortError::Unreachable { address: address.clone(), source }),
        }
    }

    /// Writes all bytes, or fails within a bounded time.
    ///
    /// # Errors
    /// If the port does not accept the bytes in time, or is lost.
    pub fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Serial(port) => port.write_all(bytes),
            Self::Tcp(stream) => stream.write_all(bytes),
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
        };
        match read {
            Ok(0) => {
                Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the other end has closed the connection"))
            }
            Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) => {
                Ok(0)
            }
            other => other,
        }
    }
}

impl AsFd for Port {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Serial(port) => port.as_fd(),
            Self::Tcp(stream) => stream.as_fd(),
        }
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        if let Self::Serial(port) = self {
            // The exclusive mode belongs to the device. It would outlive this program where another program still has
            // the device open. For a lost port the call fails without consequence.
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
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}
