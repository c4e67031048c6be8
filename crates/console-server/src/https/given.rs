//! A certificate and its key from files (PEM).

use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, Result, ensure};
use barrelman_host::input::{self, is_readable_by_others};
use tokio_rustls::rustls::client::WebPkiServerVerifier;
use tokio_rustls::rustls::client::danger::ServerCertVerifier as _;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName, UnixTime};
use tokio_rustls::rustls::{self, CertificateError, RootCertStore};

/// The files of a certificate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CertificateFiles {
    /// The certificate, and those of the authorities between it and one that devices trust (PEM).
    pub certificate: PathBuf,
    /// The certificate's key (PEM).
    pub key: PathBuf,
}

impl CertificateFiles {
    /// The certificates and the key.
    ///
    /// # Errors
    /// If a file cannot be read, or holds none.
    pub(super) fn read(&self) -> Result<(Vec<CertificateDer<'static>>, PrivateKeyDer<'static>)> {
        let (shown, shown_key) = (self.certificate.display(), self.key.display());
        let chain =
            CertificateDer::pem_slice_iter(&input::read(&self.certificate)?).collect::<Result<Vec<_>, _>>();
        let chain = chain.with_context(|| format!("{shown} is no file of certificates (PEM)"))?;
        ensure!(!chain.is_empty(), "{shown} holds no certificate (PEM)");
        if is_readable_by_others(&self.key) {
            tracing::warn!("the key {shown_key} can be read by others: run `chmod 600 {shown_key}`");
        }
        if !is_in_time(&chain) {
            tracing::warn!(
                "{shown} has expired, or is not valid yet: browsers will refuse it; look at its dates, and at the clock"
            );
        }
        let key = PrivateKeyDer::from_pem_slice(&input::read(&self.key)?);
        Ok((chain, key.with_context(|| format!("{shown_key} holds no private key (PEM)"))?))
    }
}

/// Whether the first certificate is valid now, without regard to its issuer.
fn is_in_time(chain: &[CertificateDer<'static>]) -> bool {
    let mut roots = RootCertStore::empty();
    roots.add_parsable_certificates(chain.last().cloned());
    let verifier =
        WebPkiServerVerifier::builder_with_provider(Arc::new(roots), Arc::new(default_provider())).build();
    // What it is for is looked at after its dates.
    let name = ServerName::from(IpAddr::from([127, 0, 0, 1]));
    let (Ok(verifier), [first, above @ ..]) = (verifier, chain) else { return true };
    !matches!(
        verifier.verify_server_cert(first, above, &name, &[], UnixTime::now()),
        Err(rustls::Error::InvalidCertificate(
            CertificateError::Expired
                | CertificateError::ExpiredContext { .. }
                | CertificateError::NotValidYet
                | CertificateError::NotValidYetContext { .. }
        ))
    )
}
