//! A relay to a server that speaks TLS: what this program sends to a port of the loopback goes there
//! encrypted.
//!
//! For protocols whose library has no TLS, such as RTSP. The relay listens on 127.0.0.1 alone, while the one
//! who started it keeps it, and passes bytes on; it reads none. Another program of this machine could use it,
//! too: it reaches a server that this machine reaches anyway, and gets no login from the relay.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::pin::pin;
use std::thread::JoinHandle;
use std::time::Duration;

use futures_util::future::{join, select};
use tokio::io::{AsyncWriteExt as _, copy, split};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, oneshot, watch};
use tokio::time::sleep;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::ServerName;

use crate::connection::{CONNECT_TIMEOUT, Stream};
use crate::runtime::LinkRuntime;
use crate::settings::Trust;
use crate::tls::connector;

/// Largest number of connections at a time.
const MAX_CONNECTIONS: usize = 4;
/// How long a connection goes on after one of its ends has closed: for what is still under way. An end whose
/// network is cut sends no close.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);
/// Pause after a connection that could not be accepted: too many open files stay too many for a while.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);

/// The server that a relay leads to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TlsServer {
    /// A name or an address, without brackets; the certificate must be for it.
    pub host: String,
    /// The port.
    pub port: u16,
}

/// A running relay. Dropping it closes its port and its connections.
#[derive(Debug)]
pub struct TlsRelay {
    address: SocketAddr,
    failures: watch::Receiver<Option<String>>,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl TlsRelay {
    /// Starts a relay on a free port of the loopback.
    ///
    /// # Errors
    /// If `trust` has no certificate, the host is no name, or the system refuses a port or a thread.
    pub fn start(server: TlsServer, trust: &Trust) -> io::Result<Self> {
        let tls = connector(trust)?;
        let name = ServerName::try_from(server.host.clone()).map_err(io::Error::other)?;
        let listener = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let runtime = LinkRuntime::new()?;
        let (end, ended) = oneshot::channel();
        let (report, failures) = watch::channel(None);
        let thread = std::thread::Builder::new().name("tls-relay".to_owned()).spawn(move || {
            let to = Destination { server, name, tls };
            runtime.block_on(async {
                let listening = pin!(listen(listener, &to, &report));
                select(ended, listening).await;
            });
        })?;
        Ok(Self { address, failures, end: Some(end), thread: Some(thread) })
    }

    /// Where the relay listens.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Why connections to the server cannot be made.
    pub fn failures(&self) -> RelayFailures {
        RelayFailures(self.failures.clone())
    }
}

/// Why connections of a relay cannot be made.
#[derive(Debug, Clone)]
pub struct RelayFailures(watch::Receiver<Option<String>>);

impl RelayFailures {
    /// Why the newest connection to the server could not be made; `None`: it could, or none was tried.
    pub fn newest(&self) -> Option<String> {
        self.0.borrow().clone()
    }
}

impl Drop for TlsRelay {
    fn drop(&mut self) {
        // Without a receiver, the thread has ended.
        let _ = self.end.take().map(|end| end.send(()));
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What a connection needs.
#[derive(Clone)]
struct Destination {
    server: TlsServer,
    name: ServerName<'static>,
    tls: TlsConnector,
}

async fn listen(listener: std::net::TcpListener, to: &Destination, report: &watch::Sender<Option<String>>) {
    let Ok(listener) = TcpListener::from_std(listener) else { return };
    let mut connections = tokio::task::JoinSet::new();
    loop {
        let Ok((near, _)) = listener.accept().await else {
            sleep(ACCEPT_PAUSE).await;
            continue;
        };
        while connections.len() >= MAX_CONNECTIONS {
            connections.join_next().await;
        }
        let (to, report) = (to.clone(), report.clone());
        connections.spawn(async move {
            match tokio::time::timeout(CONNECT_TIMEOUT, reach(&to)).await {
                Ok(Ok(far)) => {
                    report.send_replace(None);
                    let _ = near.set_nodelay(true);
                    pass(near, far).await;
                }
                Ok(Err(error)) => drop(report.send_replace(Some(error.to_string()))),
                Err(_) => drop(report.send_replace(Some("no answer".to_owned()))),
            }
        });
    }
}

type Encrypted = tokio_rustls::client::TlsStream<TcpStream>;

async fn reach(to: &Destination) -> io::Result<Encrypted> {
    let stream = TcpStream::connect((to.server.host.as_str(), to.server.port)).await?;
    stream.set_nodelay(true)?;
    to.tls.connect(to.name.clone(), stream).await
}

/// Passes bytes both ways until one end closes, and a little longer to the other end. What is lost with a
/// connection is the business of the protocol above.
async fn pass(near: impl Stream, far: impl Stream) {
    let (mut from_near, mut to_near) = split(near);
    let (mut from_far, mut to_far) = split(far);
    let closed = Notify::new();
    let out = async {
        let _ = copy(&mut from_near, &mut to_far).await;
        closed.notify_one();
        let _ = to_far.shutdown().await;
    };
    let back = async {
        let _ = copy(&mut from_far, &mut to_near).await;
        closed.notify_one();
        let _ = to_near.shutdown().await;
    };
    let limit = async {
        closed.notified().await;
        sleep(CLOSE_TIMEOUT).await;
    };
    select(pin!(join(out, back)), pin!(limit)).await;
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt as _, DuplexStream, duplex};

    use super::*;

    fn block_on<T>(future: impl Future<Output = T>) -> T {
        LinkRuntime::new().unwrap().block_on(future)
    }

    /// A relayed connection, with its near end and its far end as their owners see them.
    fn relayed() -> (DuplexStream, DuplexStream, impl Future<Output = ()>) {
        let ((near, program), (far, server)) = (duplex(64), duplex(64));
        (program, server, pass(near, far))
    }

    #[test]
    fn what_was_sent_before_an_end_closed_arrives() {
        let (mut program, mut server, passing) = relayed();
        let speaking = async {
            program.write_all(b"TEARDOWN").await.unwrap();
            drop(program);
            let mut heard = Vec::new();
            server.read_to_end(&mut heard).await.unwrap();
            heard
        };
        let (heard, ()) = block_on(join(speaking, passing));
        assert_eq!(heard, b"TEARDOWN");
    }

    /// One end is open and silent for ever, as after a cut of the network.
    #[test]
    fn a_connection_whose_one_end_has_closed_ends_although_the_other_is_silent() {
        let (program, _server, passing) = relayed();
        drop(program);
        block_on(passing);
        let (_program, server, passing) = relayed();
        drop(server);
        block_on(passing);
    }
}
