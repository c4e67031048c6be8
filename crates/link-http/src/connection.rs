//! A connection of HTTP/1.1 to the vehicle, with or without TLS.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use barrelman_link::url::HttpAddress;
use barrelman_wire::http::{HttpCall, Method};
use bytes::Bytes;
use http_body_util::{BodyExt as _, Full, Limited};
use hyper::body::Incoming;
use hyper::client::conn::http1::{self, SendRequest};
use hyper::header::{AUTHORIZATION, CONTENT_TYPE, HOST};
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::task::JoinHandle;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::ServerName;

use crate::authorization::{Authorization, Digest};
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
    authorization: Authorization,
}

/// A request without its address and its authorization.
#[derive(Debug, Clone)]
pub(crate) struct Asked {
    pub(crate) method: Method,
    pub(crate) path: String,
    pub(crate) content_type: &'static str,
    pub(crate) body: Option<Bytes>,
}

impl<C: HttpCall> From<&C> for Asked {
    fn from(call: &C) -> Self {
        let (method, path, body) = (call.method(), call.path(), call.body().map(Bytes::from));
        Self { method, path, content_type: C::CONTENT_TYPE, body }
    }
}

impl Connector {
    pub(crate) fn new(settings: &HttpSettings, authorization: Authorization) -> io::Result<Self> {
        let HttpSettings { address, trust, .. } = settings;
        let tls = address.scheme.is_encrypted().then(|| crate::tls::connector(trust)).transpose()?;
        Ok(Self { address: Arc::new(address.clone()), tls, authorization })
    }

    /// The same vehicle with another proof of who asks.
    pub(crate) fn with(self, authorization: Authorization) -> Self {
        Self { authorization, ..self }
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

    /// What proves who asks.
    pub(crate) const fn authorization(&self) -> &Authorization {
        &self.authorization
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
    /// What the vehicle's challenge has begun.
    digest: Option<Digest>,
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
        Ok(Self { sender, driver, digest: None })
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.sender.is_closed()
    }

    /// Sends a request and returns the answer's status and body. A challenge is answered once.
    pub(crate) async fn ask(&mut self, connector: &Connector, asked: &Asked) -> io::Result<(u16, Vec<u8>)> {
        let mut answer = self.send(connector, asked).await?;
        if answer.status() == StatusCode::UNAUTHORIZED
            && let Authorization::Digest(login) = connector.authorization()
            && let Some(digest) = Digest::begin(login, answer.headers())
        {
            // The connection takes the next request when this answer has been read, or is closed with it.
            body_of(answer).await?;
            if self.sender.ready().await.is_err() {
                *self = Self::open(connector).await?;
            }
            self.digest = Some(digest);
            answer = self.send(connector, asked).await?;
        }
        let status = answer.status().as_u16();
        Ok((status, body_of(answer).await?))
    }

    async fn send(&mut self, connector: &Connector, asked: &Asked) -> io::Result<Response<Incoming>> {
        let path = connector.path(&asked.path);
        let mut request =
            Request::builder().method(asked.method.name()).uri(&path).header(HOST, connector.authority());
        let proof = match (connector.authorization(), &mut self.digest) {
            (Authorization::Bearer(token), _) => Some(format!("Bearer {token}")),
            (Authorization::Digest(_), Some(digest)) => digest.proof(asked.method, &path),
            (Authorization::Digest(_), None) | (Authorization::None, _) => None,
        };
        if let Some(proof) = proof {
            request = request.header(AUTHORIZATION, proof);
        }
        if asked.body.is_some() {
            request = request.header(CONTENT_TYPE, asked.content_type);
        }
        let body = Full::new(asked.body.clone().unwrap_or_default());
        let request = request.body(body).map_err(io::Error::other)?;
        self.sender.ready().await.map_err(io::Error::other)?;
        self.sender.send_request(request).await.map_err(io::Error::other)
    }
}

async fn body_of(answer: Response<Incoming>) -> io::Result<Vec<u8>> {
    let body = Limited::new(answer.into_body(), MAX_BODY_BYTES);
    Ok(body.collect().await.map_err(io::Error::other)?.to_bytes().to_vec())
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.driver.abort();
    }
}
