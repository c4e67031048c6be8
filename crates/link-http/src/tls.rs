//! Which certificate of a server is accepted, and the own one.

use std::io;
use std::sync::Arc;

use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use tokio_rustls::rustls::crypto::{self, CryptoProvider};
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName, UnixTime};
use tokio_rustls::rustls::{self, ClientConfig, DigitallySignedStruct, RootCertStore, SignatureScheme};

use crate::settings::{ClientIdentity, Fingerprint, Trust};

/// The connector that accepts what `trust` says.
///
/// # Errors
/// If a file of authorities holds none.
pub(crate) fn connector(trust: &Trust) -> io::Result<TlsConnector> {
    client_config(trust, None).map(|config| TlsConnector::from(Arc::new(config)))
}

/// The client that accepts what `trust` says, and shows its own certificate where it has one and is asked for
/// it.
///
/// # Errors
/// If a file of authorities holds none, or certificate and key are not usable or do not belong together.
pub fn client_config(trust: &Trust, identity: Option<&ClientIdentity>) -> io::Result<ClientConfig> {
    let provider = Arc::new(crypto::ring::default_provider());
    let builder = ClientConfig::builder_with_provider(Arc::clone(&provider))
        .with_safe_default_protocol_versions()
        .map_err(io::Error::other)?;
    let builder = match trust {
        Trust::WellKnown => {
            let roots = RootCertStore { roots: webpki_roots::TLS_SERVER_ROOTS.to_vec() };
            builder.with_root_certificates(roots)
        }
        Trust::Authorities(pem) => builder.with_root_certificates(authorities(pem)?),
        Trust::Fingerprint(expected) => builder
            .dangerous()
            .with_custom_certificate_verifier(Arc::new(Pinned { expected: *expected, provider })),
    };
    let Some(identity) = identity else { return Ok(builder.with_no_client_auth()) };
    let chain = certificates(&identity.certificate)?;
    if chain.is_empty() {
        return Err(io::Error::other("the file of the own certificate holds none (PEM)"));
    }
    let key = PrivateKeyDer::from_pem_slice(&identity.key).map_err(|_| {
        io::Error::other("the file of the own certificate's key holds no key (PEM, not encrypted)")
    })?;
    builder.with_client_auth_cert(chain, key).map_err(io::Error::other)
}

fn authorities(pem: &[u8]) -> io::Result<RootCertStore> {
    let mut roots = RootCertStore::empty();
    for certificate in certificates(pem)? {
        roots.add(certificate).map_err(io::Error::other)?;
    }
    if roots.is_empty() {
        return Err(io::Error::other("the file of authorities holds no certificate (PEM)"));
    }
    Ok(roots)
}

fn certificates(pem: &[u8]) -> io::Result<Vec<CertificateDer<'static>>> {
    let all = CertificateDer::pem_slice_iter(pem);
    all.map(|one| one.map_err(|error| io::Error::other(error.to_string()))).collect()
}

/// Accepts the one certificate with the expected fingerprint. That the vehicle has the certificate's key is
/// checked as always.
#[derive(Debug)]
struct Pinned {
    expected: Fingerprint,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for Pinned {
    fn verify_server_cert(
        &self,
        certificate: &CertificateDer<'_>,
        _intermediates: &[CertificateDer<'_>],
        _name: &ServerName<'_>,
        _ocsp: &[u8],
        _now: UnixTime,
    ) -> Result<ServerCertVerified, rustls::Error> {
        let got = Fingerprint::of(certificate);
        if got == self.expected {
            return Ok(ServerCertVerified::assertion());
        }
        Err(rustls::Error::General(format!(
            "the certificate's SHA-256 is {got}, and {} was expected: if the certificate was renewed, compare the new one at the \
             vehicle itself (on its tablet), and give its SHA-256 instead",
            self.expected
        )))
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        let algorithms = &self.provider.signature_verification_algorithms;
        crypto::verify_tls12_signature(message, certificate, signature, algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        let algorithms = &self.provider.signature_verification_algorithms;
        crypto::verify_tls13_signature(message, certificate, signature, algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}
