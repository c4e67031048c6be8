//! A connection to a server of TAK, with TLS or without.

use std::io::{self, ErrorKind, Read, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio_rustls::rustls::pki_types::ServerName;
use tokio_rustls::rustls::{ClientConfig, ClientConnection, StreamOwned};

/// How long a connection may take to be made, and TLS on it.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);
/// A server that takes nothing for this long is given up.
const WRITE_TIMEOUT: Duration = Duration::from_secs(1);
/// A server of TLS 1.3 refuses a client's certificate after the client takes the connection for made.
const REFUSAL_TIMEOUT: Duration = Duration::from_millis(500);
/// Most bytes that are read and dropped at a time: a server sends the events of all others.
const MOST_READ: usize = 1 << 20;

/// What TLS needs: which certificates are accepted, for which name.
#[derive(Debug, Clone)]
pub struct Encryption {
    /// Which certificates are accepted, and the own one.
    pub config: Arc<ClientConfig>,
    /// The name or address that the server's certificate must be for.
    pub name: ServerName<'static>,
}

/// An open connection.
#[derive(Debug)]
pub(super) enum Line {
    Plain(TcpStream),
    Encrypted(Box<StreamOwned<ClientConnection, TcpStream>>),
}

impl Line {
    /// Connects.
    ///
    /// # Errors
    /// If nobody takes the connection in time, or, with TLS, its certificate is not accepted.
    pub(super) fn connect(to: SocketAddr, encryption: Option<&Encryption>) -> io::Result<Self> {
        let stream = TcpStream::connect_timeout(&to, CONNECT_TIMEOUT)?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        stream.set_nodelay(true)?;
        Ok(match encryption {
            Some(encryption) => Self::Encrypted(Box::new(encrypted(stream, encryption)?)),
            None => Self::Plain(stream),
        })
    }

    pub(super) fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Plain(stream) => stream.write_all(bytes),
            Self::Encrypted(stream) => stream.write_all(bytes).and_then(|()| stream.flush()),
        }
    }

    /// Reads what the server sent, so that it need not wait.
    ///
    /// # Errors
    /// If the server has closed the connection.
    pub(super) fn drop_received(&mut self) -> io::Result<()> {
        self.socket().set_nonblocking(true)?;
        match self {
            Self::Plain(stream) => drop_all(stream),
            Self::Encrypted(stream) => drop_all(stream),
        }?;
        self.socket().set_nonblocking(false)
    }

    /// Waits for a server that does not accept the own certificate.
    ///
    /// # Errors
    /// If it does not.
    pub(super) fn wait_for_refusal(&mut self) -> io::Result<()> {
        let Self::Encrypted(stream) = self else { return Ok(()) };
        stream.sock.set_read_timeout(Some(REFUSAL_TIMEOUT))?;
        match stream.read(&mut [0]) {
            Ok(0) => Err(closed()),
            Err(error) if !is_wait(&error) => Err(error),
            Ok(_) | Err(_) => Ok(()),
        }
    }

    pub(super) fn socket(&self) -> &TcpStream {
        match self {
            Self::Plain(stream) => stream,
            Self::Encrypted(stream) => &stream.sock,
        }
    }
}

/// TLS on a connection, within the time of a connection, however slowly the server answers.
fn encrypted(
    mut stream: TcpStream,
    encryption: &Encryption,
) -> io::Result<StreamOwned<ClientConnection, TcpStream>> {
    let deadline = Instant::now() + CONNECT_TIMEOUT;
    let late = || io::Error::new(ErrorKind::TimedOut, "the server does not answer in TLS");
    let config = Arc::clone(&encryption.config);
    let mut tls = ClientConnection::new(config, encryption.name.clone()).map_err(io::Error::other)?;
    while tls.is_handshaking() || tls.wants_write() {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(late());
        }
        if tls.wants_write() {
            tls.write_tls(&mut stream)?;
            continue;
        }
        stream.set_read_timeout(Some(left))?;
        let read = tls.read_tls(&mut stream).map_err(|error| if is_wait(&error) { late() } else { error })?;
        if read == 0 {
            return Err(closed());
        }
        if let Err(error) = tls.process_new_packets() {
            // The server hears why.
            let _ = tls.write_tls(&mut stream);
            return Err(io::Error::new(ErrorKind::InvalidData, error));
        }
    }
    Ok(StreamOwned::new(tls, stream))
}

fn drop_all(stream: &mut impl Read) -> io::Result<()> {
    let mut buffer = [0; 16_384];
    let mut read = 0;
    while read < MOST_READ {
        match stream.read(&mut buffer) {
            Ok(0) => return Err(closed()),
            Ok(bytes) => read += bytes,
            Err(error) if error.kind() == ErrorKind::WouldBlock => break,
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

fn is_wait(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

fn closed() -> io::Error {
    io::Error::new(ErrorKind::ConnectionAborted, "the server closed the connection")
}
