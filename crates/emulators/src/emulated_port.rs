//! The port of an emulated vehicle: a pseudo-terminal with a symbolic link, a TCP listener, or a UDP socket.

use std::fs::OpenOptions;
use std::io::{self, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::os::fd::{AsFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::port_link::PortLink;

/// A port for clients.
#[derive(Debug)]
pub enum EmulatedPort {
    /// A pseudo-terminal.
    Pty(Pty),
    /// A TCP listener with at most one client.
    Tcp(TcpPort),
    /// Datagrams to the sender of the newest one.
    Udp(UdpPort),
}

/// A UDP socket. Its client is the sender of the newest datagram.
#[derive(Debug)]
pub struct UdpPort {
    socket: UdpSocket,
    client: Option<SocketAddr>,
    is_unplugged: bool,
}

/// A TCP listener with at most one client. A client that was silent for a while makes room for another one.
#[derive(Debug)]
pub struct TcpPort {
    listener: TcpListener,
    /// The client and when it last sent anything.
    client: Option<(TcpStream, Instant)>,
    silent_after: Duration,
}

/// How long a client must have been silent to make room for another one that connects.
const SILENT_AFTER: Duration = Duration::from_secs(5);

/// A pseudo-terminal with a symbolic link for clients. Dropping it removes the link.
#[derive(Debug)]
pub struct Pty {
    link: PortLink,
    /// Whether another symbolic link at the link's path may be replaced.
    force: bool,
    master: OwnedFd,
}

impl EmulatedPort {
    /// Creates a pseudo-terminal and a symbolic link to it at `link`. A link to a pseudo-terminal that no
    /// longer exists is replaced; with `force`, any symbolic link.
    ///
    /// # Errors
    /// If something else lies at `link`, or the system has no pseudo-terminal left.
    pub fn pty(link: &Path, force: bool) -> Result<Self> {
        Ok(Self::Pty(Pty::open(link, force)?))
    }

    /// Listens for TCP connections.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub fn listen(address: &str) -> Result<Self> {
        Self::listen_with(address, SILENT_AFTER)
    }

    /// Listens for TCP connections. A client that was silent for `silent_after` makes room for another one.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub fn listen_with(address: &str, silent_after: Duration) -> Result<Self> {
        let listener = TcpListener::bind(address).with_context(|| format!("cannot listen on {address}"))?;
        listener.set_nonblocking(true)?;
        Ok(Self::Tcp(TcpPort { listener, client: None, silent_after }))
    }

    /// Takes datagrams at an address.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub fn datagrams(address: &str) -> Result<Self> {
        let socket = UdpSocket::bind(address).with_context(|| format!("cannot listen on {address}"))?;
        socket.set_nonblocking(true)?;
        Ok(Self::Udp(UdpPort { socket, client: None, is_unplugged: false }))
    }

    /// Whether other machines can reach the port.
    pub fn is_public(&self) -> bool {
        match self {
            Self::Pty(_) => false,
            Self::Tcp(port) => port.listener.local_addr().is_ok_and(|address| !address.ip().is_loopback()),
            Self::Udp(port) => port.socket.local_addr().is_ok_and(|address| !address.ip().is_loopback()),
        }
    }

    /// The URL of the port, for `--link`.
    pub fn url(&self) -> String {
        match self {
            Self::Pty(pty) => format!("serial:{}", pty.link.path().display()),
            Self::Tcp(port) => port
                .listener
                .local_addr()
                .map_or_else(|_| "tcp: (unknown address)".to_owned(), |address| format!("tcp://{address}")),
            Self::Udp(port) => port
                .socket
                .local_addr()
                .map_or_else(|_| "udp: (unknown address)".to_owned(), |address| format!("udp://{address}")),
        }
    }

    /// Waits at most `wait` for bytes and reads them. Returns the number of bytes, 0 for none.
    pub fn read(&mut self, buffer: &mut [u8], wait: Duration) -> usize {
        match self {
            Self::Pty(pty) => pty.read(buffer, wait),
            Self::Tcp(port) => port.read(buffer, wait),
            Self::Udp(port) => port.read(buffer, wait),
        }
    }

    /// Writes without blocking. Bytes that do not fit are lost, as on a serial line without a reader.
    pub fn write(&mut self, bytes: &[u8]) {
        // A port without a client is not an error.
        match self {
            Self::Pty(pty) => drop(rustix::io::write(&pty.master, bytes)),
            Self::Tcp(TcpPort { client: Some((client, _)), .. }) => drop(client.write(bytes)),
            Self::Tcp(TcpPort { client: None, .. }) | Self::Udp(UdpPort { client: None, .. }) => {}
            Self::Udp(UdpPort { socket, client: Some(client), .. }) => drop(socket.send_to(bytes, *client)),
        }
    }

    /// Cuts the connection, as when the cable is unplugged: the link of a pseudo-terminal is removed.
    pub fn unplug(&mut self) {
        match self {
            Self::Pty(pty) => pty.link.remove(),
            Self::Tcp(port) => port.client = None,
            Self::Udp(port) => (port.client, port.is_unplugged) = (None, true),
        }
    }

    /// Reconnects after `unplug`, with a new pseudo-terminal, as for a device that is plugged in again.
    /// Connections that were made meanwhile are closed: nobody was there.
    ///
    /// # Errors
    /// If the system has no pseudo-terminal left, or something else lies at the link's path.
    pub fn plug(&mut self) -> Result<()> {
        match self {
            Self::Pty(pty) => *pty = Pty::open(pty.link.path(), pty.force)?,
            Self::Tcp(port) => {
                port.client = None;
                while port.listener.accept().is_ok() {}
            }
            Self::Udp(port) => port.is_unplugged = false,
        }
        Ok(())
    }
}

impl Pty {
    fn open(link: &Path, force: bool) -> Result<Self> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let device = PathBuf::from(name.to_string_lossy().into_owned());
        // Raw mode: an echoing line discipline would send the station's own output back to it.
        let slave = OpenOptions::new().read(true).write(true).open(&device)?;
        let mut raw = tcgetattr(&slave)?;
        raw.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &raw)?;
        rustix::io::ioctl_fionbio(&master, true)?;
        Ok(Self { link: PortLink::create(link, &device, force)?, force, master })
    }

    fn read(&self, buffer: &mut [u8], wait: Duration) -> usize {
        if !is_readable(&self.master, wait) {
            return 0;
        }
        rustix::io::read(&self.master, buffer).unwrap_or_else(|_| {
            // Without a client, poll reports a hang-up at once, every time.
            std::thread::sleep(wait.min(Duration::from_millis(5)));
            0
        })
    }
}

impl UdpPort {
    /// Reads a datagram. What comes while the port is unplugged is lost.
    fn read(&mut self, buffer: &mut [u8], wait: Duration) -> usize {
        if !is_readable(&self.socket, wait) {
            return 0;
        }
        match self.socket.recv_from(buffer) {
            Ok((read, client)) if !self.is_unplugged => {
                self.client = Some(client);
                read
            }
            // An answer to a client that is gone is reported as an error of the next call.
            Ok(_) | Err(_) => 0,
        }
    }
}

impl TcpPort {
    fn read(&mut self, buffer: &mut [u8], wait: Duration) -> usize {
        let is_silent = |(_, heard): &(TcpStream, Instant)| heard.elapsed() >= self.silent_after;
        if self.client.as_ref().is_some_and(is_silent) && is_readable(&self.listener, Duration::ZERO) {
            self.client = None;
        }
        let Some((stream, heard)) = self.client.as_mut() else {
            if is_readable(&self.listener, wait)
                && let Ok((stream, _)) = self.listener.accept()
                && stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).is_ok()
            {
                self.client = Some((stream, Instant::now()));
            }
            return 0;
        };
        if !is_readable(&*stream, wait) {
            return 0;
        }
        match stream.read(buffer) {
            Ok(read) if read > 0 => {
                *heard = Instant::now();
                read
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => 0,
            Ok(_) | Err(_) => {
                self.client = None;
                0
            }
        }
    }
}

fn is_readable(fd: impl AsFd, wait: Duration) -> bool {
    let mut fds = [PollFd::new(&fd, PollFlags::IN)];
    let timeout = rustix::event::Timespec::try_from(wait).ok();
    // A signal may shorten the wait.
    poll(&mut fds, timeout.as_ref()).is_ok_and(|ready| ready > 0)
}
