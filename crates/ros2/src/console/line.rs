//! Lines to the console: TCP, with TLS off loopback.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use hyper::header::HeaderValue;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpStream, lookup_host};
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

use crate::settings::{Address, Settings};

/// Longest time until a line is open, TLS included.
const OPEN_TIMEOUT: Duration = Duration::from_secs(2);

/// A stream of bytes to the console.
pub trait Stream: AsyncRead + AsyncWrite + Unpin + Send {}
impl<T: AsyncRead + AsyncWrite + Unpin + Send> Stream for T {}

/// How to reach the console.
pub struct Line {
    address: Address,
    tls: Option<TlsConnector>,
    authorization: Option<HeaderValue>,
}

impl Line {
    /// A way to the console of these settings.
    ///
    /// # Errors
    /// If the file of authorities holds none.
    pub fn new(settings: &Settings) -> Result<Self> {
        let tls = settings.authorities.as_deref().map(connector).transpose().context("--ca")?;
        let bearer = settings.token.as_ref().map(|token| {
            let mut value = HeaderValue::from_str(&format!("Bearer {token}"))?;
            value.set_sensitive(true);
            anyhow::Ok(value)
        });
        let authorization = bearer.transpose().context("--token-file")?;
        Ok(Self { address: settings.address.clone(), tls, authorization })
    }

    /// The address, for messages.
    pub fn url(&self) -> String {
        format!("{}://{}", if self.tls.is_some() { "https" } else { "http" }, self.authority())
    }

    /// Host and port, as a request names them.
    pub fn authority(&self) -> String {
        self.address.authority()
    }

    /// Proves who asks.
    pub const fn authorization(&self) -> Option<&HeaderValue> {
        self.authorization.as_ref()
    }

    /// Opens a line. Dropping it discards what was not sent yet: nothing arrives after it was given up.
    ///
    /// # Errors
    /// If the console is not reached in time, or proves not to be the one of the certificate authority.
    pub async fn open(&self) -> io::Result<Box<dyn Stream>> {
        timeout(OPEN_TIMEOUT, self.open_without_limit())
            .await
            .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    async fn open_without_limit(&self) -> io::Result<Box<dyn Stream>> {
        let Address { host, port, .. } = &self.address;
        let mut failure = io::ErrorKind::AddrNotAvailable.into();
        for address in lookup_host((host.as_str(), *port)).await? {
            // The name `localhost` may be another host's.
            if self.tls.is_none() && !address.ip().is_loopback() {
                continue;
            }
            match TcpStream::connect(address).await {
                Ok(stream) => return self.secured(stream).await,
                Err(error) => failure = error,
            }
        }
        Err(failure)
    }

    async fn secured(&self, stream: TcpStream) -> io::Result<Box<dyn Stream>> {
        // A stop must not wait for more bytes.
        stream.set_nodelay(true)?;
        stream.set_zero_linger()?;
        let Some(tls) = &self.tls else { return Ok(Box::new(stream)) };
        let name = ServerName::try_from(self.address.host.clone()).map_err(io::Error::other)?;
        Ok(Box::new(tls.connect(name, stream).await?))
    }
}

/// TLS with a console whose certificate one of these authorities has signed.
fn connector(pem: &[u8]) -> Result<TlsConnector> {
    let mut roots = RootCertStore::empty();
    for certificate in CertificateDer::pem_slice_iter(pem) {
        roots.add(certificate.context("the file is no PEM file")?)?;
    }
    if roots.is_empty() {
        bail!("the file holds no certificate (PEM)");
    }
    let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()?
        .with_root_certificates(roots)
        .with_no_client_auth();
    Ok(TlsConnector::from(Arc::new(config)))
}
