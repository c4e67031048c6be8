//! A relay on the loopback in front of one connection to an RTSP server, through [`super::rtsp_filter`].
//!
//! The relay belongs to the runtime of the connection and ends with it. It accepts one connection, that of
//! the RTSP library, and reaches one server: wherever an answer leads, a login goes nowhere else.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::net::{TcpListener, TcpStream};
use url::{Host, Url};

use super::rtsp_filter::{AnswerFilter, Refusal, RequestFilter};
use super::url::RTSP_PORT;

/// Bytes that are read at once.
const READ_BYTES: usize = 64 << 10;

/// What became of a relay's connection.
#[derive(Debug, Clone, Default)]
pub(super) struct RelayEnd(Arc<Mutex<Option<Ended>>>);

#[derive(Debug, Clone)]
enum Ended {
    Refused(Refusal),
    /// Why, in words.
    Unreachable(String),
}

impl RelayEnd {
    fn set(&self, ended: Option<Ended>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = ended;
    }

    fn get(&self) -> Option<Ended> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Why the filter has ended the connection; `None`: it has not.
    pub(super) fn refusal(&self) -> Option<Refusal> {
        match self.get() {
            Some(Ended::Refused(refusal)) => Some(refusal),
            Some(Ended::Unreachable(_)) | None => None,
        }
    }

    /// Whether the server was reached.
    pub(super) fn is_reached(&self) -> bool {
        !matches!(self.get(), Some(Ended::Unreachable(_)))
    }

    /// Why there was no connection, or an early end of it, in words.
    pub(super) fn reason(&self) -> Option<String> {
        match self.get()? {
            Ended::Refused(refusal) => Some(refusal.to_string()),
            Ended::Unreachable(why) => Some(format!("the server cannot be reached: {why}")),
        }
    }
}

/// Starts a relay to the server of an address, as a task of this runtime. Returns the address that leads
/// through the relay, and what says how the relay ended.
///
/// # Errors
/// If the system has no free port.
pub(super) async fn start(address: &Url, permits_basic: bool) -> io::Result<(Url, RelayEnd)> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let near = listener.local_addr()?;
    let mut through = address.clone();
    let is_set = through.set_host(Some("127.0.0.1")).is_ok() && through.set_port(Some(near.port())).is_ok();
    if !is_set {
        return Err(io::Error::from(io::ErrorKind::InvalidInput));
    }
    let end = RelayEnd::default();
    let (server, told) = (address.clone(), end.clone());
    tokio::spawn(async move {
        let ended = relay(&listener, &server, near, permits_basic).await;
        told.set(ended);
    });
    Ok((through, end))
}

async fn relay(listener: &TcpListener, server: &Url, near: SocketAddr, permits_basic: bool) -> Option<Ended> {
    // The library connects first. Where the server cannot be reached, its connection ends.
    let (client, _) = listener.accept().await.ok()?;
    let server = match connect(server).await {
        Ok(server) => server,
        Err(error) => return Some(Ended::Unreachable(error.to_string())),
    };
    let _ = client.set_nodelay(true);
    let _ = server.set_nodelay(true);
    pass(&client, &server, near, permits_basic).await.err().map(Ended::Refused)
}

async fn connect(server: &Url) -> io::Result<TcpStream> {
    let port = server.port().unwrap_or(RTSP_PORT);
    match server.host() {
        Some(Host::Domain(name)) => TcpStream::connect((name, port)).await,
        Some(Host::Ipv4(address)) => TcpStream::connect((address, port)).await,
        Some(Host::Ipv6(address)) => TcpStream::connect((address, port)).await,
        None => Err(io::Error::from(io::ErrorKind::InvalidInput)),
    }
}

/// Passes messages both ways until an end closes.
async fn pass(
    client: &TcpStream,
    server: &TcpStream,
    near: SocketAddr,
    permits_basic: bool,
) -> Result<(), Refusal> {
    let (mut requests, mut answers) = (RequestFilter::new(permits_basic), AnswerFilter::new(near));
    let (mut from_client, mut from_server) = (vec![0; READ_BYTES], vec![0; READ_BYTES]);
    let (mut to_client, mut to_server) = (Vec::new(), Vec::new());
    loop {
        let read = next_readable(client, server).await;
        let is_open = match read {
            Readable::Client => match client.try_read(&mut from_client) {
                Ok(0) => false,
                Ok(length) => {
                    requests.pass(&from_client[..length], &mut to_server)?;
                    true
                }
                Err(error) => error.kind() == io::ErrorKind::WouldBlock,
            },
            Readable::Server => match server.try_read(&mut from_server) {
                Ok(0) => false,
                Ok(length) => {
                    let before = answers.requests();
                    answers.pass(&from_server[..length], &mut to_client, &mut to_server)?;
                    if before == 0 && answers.requests() > 0 {
                        tracing::warn!(
                            "the RTSP server sends requests of its own; they are answered with 501"
                        );
                    }
                    true
                }
                Err(error) => error.kind() == io::ErrorKind::WouldBlock,
            },
            Readable::Gone => false,
        };
        let is_written = write_all(server, &mut to_server).await.is_ok()
            && write_all(client, &mut to_client).await.is_ok();
        if !(is_open && is_written) {
            return Ok(());
        }
    }
}

/// Which end has something to read.
enum Readable {
    Client,
    Server,
    Gone,
}

/// Waits until an end has something to read, or has closed.
async fn next_readable(client: &TcpStream, server: &TcpStream) -> Readable {
    let (near, far) = (std::pin::pin!(client.readable()), std::pin::pin!(server.readable()));
    match futures_util::future::select(near, far).await {
        futures_util::future::Either::Left((Ok(()), _)) => Readable::Client,
        futures_util::future::Either::Right((Ok(()), _)) => Readable::Server,
        futures_util::future::Either::Left((Err(_), _))
        | futures_util::future::Either::Right((Err(_), _)) => Readable::Gone,
    }
}

/// Writes all of `bytes`, and empties them. One end that does not read holds the other: nothing is kept for
/// it beyond what was read at once.
async fn write_all(stream: &TcpStream, bytes: &mut Vec<u8>) -> io::Result<()> {
    let mut written = 0;
    while written < bytes.len() {
        stream.writable().await?;
        match stream.try_write(&bytes[written..]) {
            Ok(length) => written += length,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => return Err(error),
        }
    }
    bytes.clear();
    Ok(())
}
