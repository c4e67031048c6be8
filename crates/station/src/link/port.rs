//! Serial ports and TCP connections as one thing: bytes in and out, with a bound on every wait.
//!
//! A serial port is locked twice, so that nobody else talks on it meanwhile: `flock` keeps out other programs
//! that ask for the lock, root's too, and `TIOCEXCL` keeps out those that do not ask. Lock files are not used:
//! they outlive the programs that made them.

use std::io::{self, Read as _, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::os::fd::{AsFd, BorrowedFd};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::FlockOperation;
use serial2::SerialPort;

use super::url::Endpoint;

/// How long a write may take before the port counts as dead.
const WRITE_TIMEOUT: Duration = Duration::from_millis(500);
/// How long connecting may take.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(1);

/// A port cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// There is no such device.
    #[error("the port {} does not exist: is the ground station plugged in and on? `ls /dev/ttyACM* /dev/ttyUSB*` lists what is there", path.display())]
    Missing {
        /// The device.
        path: PathBuf,
    },
    /// This user may not open it.
    #[error(
        "the port {} may not be opened by this user: add the user to its group (`sudo usermod -aG dialout $USER`, \
         then log in again), or install config/udev/70-barrelman.rules", path.display()
    )]
    NotAllowed {
        /// The device.
        path: PathBuf,
    },
    /// Another program uses it.
    #[error(
        "the port {} is taken by another program: `fuser -v {}` names it; ModemManager is kept away by \
         config/udev/70-barrelman.rules", path.display(), path.display()
    )]
    Taken {
        /// The device.
        path: PathBuf,
    },
    /// It is no serial port.
    #[error("{} is no serial port: name its device, as in serial:/dev/ttyACM0 (`ls /dev/ttyACM* /dev/ttyUSB*` lists them)", path.display())]
    NotSerial {
        /// The file.
        path: PathBuf,
    },
    /// Nobody answers at that address.
    #[error("{address} cannot be connected to: is the pass-through server on the ground computer running?")]
    Unreachable {
        /// `host:port`.
        address: String,
        /// What the system says.
        source: io::Error,
    },
    /// A simulated camera has no port.
    #[error("sim: is no port: it moves the camera of the world that --video sim:SCENARIO shows")]
    Simulated,
    /// Anything else.
    #[error("the port {} cannot be opened", path.display())]
    Other {
        /// The device.
        path: PathBuf,
        /// What the system says.
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
            Endpoint::World => Err(PortError::Simulated),
            Endpoint::Tcp { address } => connect(address)
                .map(Self::Tcp)
                .map_err(|source| PortError::Unreachable { address: address.clone(), source }),
        }
    }

    /// Writes all bytes, or fails within a bounded time.
    ///
    /// # Errors
    /// If the port takes no bytes any more.
    pub fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Serial(port) => port.write_all(bytes),
            Self::Tcp(stream) => stream.write_all(bytes),
        }
    }

    /// Reads what has come, after `poll` has said that there is something.
    ///
    /// # Errors
    /// If the port is gone; a connection that was closed at the other end is an error too.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = match self {
            Self::Serial(port) => port.read(buffer),
            Self::Tcp(stream) => stream.read(buffer),
        };
        match read {
            Ok(0) => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the other end has gone")),
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
            // The exclusive mode belongs to the device and would outlive this program where another still has it
            // open. A port that is gone cannot be told, and need not be.
            let _ = rustix::termios::ioctl_tiocnxcl(port.as_fd());
        }
    }
}

fn open_serial(path: &Path, baud: u32) -> Result<SerialPort, PortError> {
    let path_buf = || path.to_path_buf();
    let explain = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => PortError::Missing { path: path_buf() },
        io::ErrorKind::PermissionDenied => PortError::NotAllowed { path: path_buf() },
        io::ErrorKind::ResourceBusy => PortError::Taken { path: path_buf() },
        _ => PortError::Other { path: path_buf(), source },
    };
    // A directory or a plain file is told apart before the terminal settings fail on it with an odd message.
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
            PortError::Taken { path: path_buf() }
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
