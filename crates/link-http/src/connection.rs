//! A connection of HTTP/1.1 to the vehicle, with or without TLS.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use barrelman_link::url::HttpAddress;
use bytes::Bytes;
use http_body_util::{BodyExt as _, Full, Limited};
use hyper::client::conn::http1::{self, SendRequest};
use hyper::header::{AUTHORIZATION, CONTENT_TYPE, HOST};
use hyper::{Method, Request};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::task::JoinHandle;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::ServerName;

use crate::settings::HttpSettings;

/// Largest body of an answer, bytes.
const MAX_BODY_BYTES: usize = 256 << 10;
/// Largest head of an answer, bytes.
const MAX_HEAD_BYTES: usize = 64 << 10;
/// Longest time until a connection is made, TLS included.
pub(crate) const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);

/// A stream of bytes to the vehicle.
pub(crate) trait Stream: AsyncRead + AsyncWrite + Unpin + Send {}
impl<T: AsyncRead + AsyncWrite + Unpin + Send> Stream for T {}

/// Makes connections.
#[derive(Clone)]
pub(crate) struct Connector {
    address: Arc<HttpAddress>,
    tls: Option<TlsConnector>,
}

/// A request without its address and its token.
#[derive(Debug, Clone)]
pub(crate) struct Asked {
    pub(crate) method: Method,
    pub(crate) path: String,
    pub(crate) body: Option<String>,
}

impl Connector {
    pub(crate) fn new(settings: &HttpSettings) -> io::Result<Self> {
        let HttpSettings { address, trust, .. } = settings;
        let tls = address.is_encrypted.then(|| crate::tls::connector(trust)).transpose()?;
        Ok(Self { address: Arc::new(address.clone()), tls })
    }

    /// Connects, within a bounded time.
    pub(crate) async fn connect(&self) -> io::Result<Box<dyn Stream>> {
        let connected = tokio::time::timeout(CONNECT_TIMEOUT, self.connect_without_limit()).await;
        connected.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    async fn connect_without_limit(&self) -> io::Result<Box<dyn Stream>> {
        let stream = TcpStream::connect((self.address.host.as_str(), self.address.port)).await?;
        // A command to rest must not wait for more bytes.
        stream.set_nodelay(true)?;
        let Some(tls) = &self.tls else { return Ok(Box::new(stream)) };
        let name = ServerName::try_from(self.address.host.clone()).map_err(io::Error::other)?;
        Ok(Box::new(tls.connect(name, stream).await?))
    }

    /// The address of a path of the API, as a request to the host names it.
    pub(crate) fn path(&self, path: &str) -> String {
        format!("{}{path}", self.address.path)
    }

    pub(crate) fn authority(&self) -> String {
        self.address.authority()
    }
}

/// An open connection.
pub(crate) struct Connection {
    sender: SendRequest<Full<Bytes>>,
    driver: JoinHandle<()>,
}

impl Connection {
    pub(crate) async fn open(connector: &Connector) -> io::Result<Self> {
        let stream = connector.connect().await?;
        let (sender, connection) = http1::Builder::new()
            .max_buf_size(MAX_HEAD_BYTES)
            .handshake(TokioIo::new(stream))
            .await
            .map_err(io::Error::other)?;
        // The end of a connection is seen by its next request.
        let driver = tokio::spawn(async move { drop(connection.await) });
        Ok(Self { sender, driver })
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.sender.is_closed()
    }

    /// Sends a request and returns the answer's status and body.
    pub(crate) async fn ask(
        &mut self,
        connector: &Connector,
        token: &str,
        asked: Asked,
    ) -> io::Result<(u16, Vec<u8>)> {
        let mut request = Request::builder()
            .method(asked.method)
            .uri(connector.path(&asked.path))
            .header(HOST, connector.authority());
        if !token.is_empty() {
            request = request.header(AUTHORIZATION, format!("Bearer {token}"));
        }
        if asked.body.is_some() {
            request = request.header(CONTENT_TYPE, "application/json");
        }
        let body = Full::new(Bytes::from(asked.body.unwrap_or_default()));
        let request = request.body(body).map_err(io::Error::other)?;
        self.sender.ready().await.map_err(io::Error::other)?;
        let answer = self.sender.send_request(request).await.map_err(io::Error::other)?;
        let status = answer.status().as_u16();
        let body = Limited::new(answer.into_body(), MAX_BODY_BYTES);
        let body = body.collect().await.map_err(io::Error::other)?.to_bytes();
        Ok((status, body.to_vec()))
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.driver.abort();
    }
}
