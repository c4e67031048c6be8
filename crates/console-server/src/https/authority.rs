//! The program's own certificate authority. It is made once and kept in a file, with its key, for its owner
//! alone.
//!
//! The authority is limited to this program's names (name constraints, RFC 5280, section 4.2.1.10): anyone
//! who steals its key cannot pretend to be another web site. Addresses in numbers are not limited, since they
//! change with the network.

use std::collections::BTreeSet;
use std::fs;
use std::net::IpAddr;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::{Context as _, Result};
use barrelman_host::input::{self, is_readable_by_others};
use barrelman_host::output::OutputFile;
use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, GeneralSubtree,
    IsCa, Issuer, KeyPair, KeyUsagePurpose, NameConstraints,
};
use ring::digest::{SHA256, digest};
use serde::{Deserialize, Serialize};
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};

const DAY: Duration = Duration::from_secs(86_400);
/// How long the authority is valid.
const AUTHORITY_LIFE: Duration = DAY.saturating_mul(730);
/// How long before its end the authority is made anew: no sortie has to outlast it.
const RENEWED_BEFORE: Duration = DAY.saturating_mul(7);
/// How long a server's certificate is valid.
pub(super) const CERTIFICATE_LIFE: Duration = DAY.saturating_mul(90);
/// By how much a device's clock may be late.
pub(super) const LATE_CLOCK: Duration = DAY;

/// The file's content.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    /// The common name.
    name: String,
    /// The names that the authority is limited to, and those below them.
    permitted: BTreeSet<String>,
    /// The end of its validity, seconds since 1970.
    expires_s: u64,
    /// PEM.
    certificate: String,
    /// PEM.
    key: String,
}

/// What everybody may know of an authority.
#[derive(Debug, Clone)]
pub(crate) struct PublicAuthority {
    /// The certificate, PEM.
    pub(crate) pem: String,
    /// The certificate, DER.
    pub(crate) der: CertificateDer<'static>,
    /// SHA-256 of the certificate, as browsers show it.
    pub(crate) fingerprint: String,
}

/// An authority with its key.
pub(super) struct Authority {
    issuer: Issuer<'static, KeyPair>,
    permitted: BTreeSet<String>,
    expires: SystemTime,
    shown: PublicAuthority,
}

impl Authority {
    /// The authority of a file, which is made where it is missing, or where the authority ends soon.
    ///
    /// # Errors
    /// If the file cannot be read or made, or is not usable.
    pub(super) fn kept_in(path: &Path, permitted: &BTreeSet<String>, now: SystemTime) -> Result<Self> {
        let shown = path.display();
        let context = || format!("the console's certificate authority cannot be kept in {shown}");
        let is_there = path.try_exists().with_context(context)?;
        // A power cut may have left an empty file.
        let text = if is_there { input::read(path).with_context(context)? } else { Vec::new() };
        if !text.is_empty() {
            if is_readable_by_others(path) {
                tracing::warn!(
                    "the key of the console's certificate authority can be read by others: run `chmod 600 {shown}`"
                );
            }
            let authority = Self::parse(&text).with_context(|| {
                format!("{shown} is no certificate authority of the console: remove the file; each device has to trust the new one")
            })?;
            if now + RENEWED_BEFORE < authority.expires {
                return Ok(authority);
            }
            tracing::warn!(
                "the console's certificate authority has come to its end: each device has to trust a new one"
            );
        }
        let kept = Kept::make(permitted, now).with_context(context)?;
        let text = serde_json::to_vec(&kept).with_context(context)?;
        if let Some(folder) = path.parent() {
            fs::DirBuilder::new().recursive(true).mode(0o700).create(folder).with_context(context)?;
        }
        let file = OutputFile::open(path, is_there).with_context(context)?;
        file.write_whole(&text).with_context(context)?;
        tracing::info!("the console's certificate authority was made, and is kept in {shown}");
        Self::parse(&text)
    }

    fn parse(text: &[u8]) -> Result<Self> {
        let Kept { name, permitted, expires_s, certificate, key } = serde_json::from_slice(text)?;
        let key = KeyPair::from_pem(&key)?;
        let der = CertificateDer::from_pem_slice(certificate.as_bytes())?;
        let issuer = Issuer::new(authority_params(&name, &permitted), key);
        let fingerprint = fingerprint(&der);
        Ok(Self {
            issuer,
            permitted,
            expires: UNIX_EPOCH + Duration::from_secs(expires_s),
            shown: PublicAuthority { pem: certificate, der, fingerprint },
        })
    }

    /// Whether the authority may issue certificates for this name.
    pub(super) fn permits(&self, name: &str) -> bool {
        let is_below = |own: &String| {
            name.strip_suffix(own.as_str()).is_some_and(|rest| rest.is_empty() || rest.ends_with('.'))
        };
        name.parse::<IpAddr>().is_ok() || self.permitted.iter().any(is_below)
    }

    /// A certificate for these names and addresses with a new key. The chain includes the authority, so that
    /// browsers show its fingerprint.
    pub(super) fn issue(
        &self,
        names: &BTreeSet<String>,
        now: SystemTime,
    ) -> Result<(Vec<CertificateDer<'static>>, PrivateKeyDer<'static>)> {
        let key = KeyPair::generate()?;
        let mut params = CertificateParams::new(names.iter().cloned().collect::<Vec<_>>())?;
        params.distinguished_name = common_name("Barrelman console");
        params.not_before = (now - LATE_CLOCK).into();
        params.not_after = (now + CERTIFICATE_LIFE).into();
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        params.use_authority_key_identifier_extension = true;
        let certificate = params.signed_by(&key, &self.issuer)?;
        let chain = vec![certificate.der().clone(), self.shown.der.clone()];
        Ok((chain, PrivateKeyDer::Pkcs8(key.serialize_der().into())))
    }

    /// What everybody may know.
    pub(super) const fn shown(&self) -> &PublicAuthority {
        &self.shown
    }
}

impl Kept {
    /// A new authority.
    fn make(permitted: &BTreeSet<String>, now: SystemTime) -> Result<Self> {
        let key = KeyPair::generate()?;
        let made_s = now.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
        // Two authorities of one machine have different names.
        let name = format!("Barrelman console {made_s:x}");
        let mut params = authority_params(&name, permitted);
        params.not_before = (now - LATE_CLOCK).into();
        params.not_after = (now + AUTHORITY_LIFE).into();
        let certificate = params.self_signed(&key)?.pem();
        let expires_s = made_s + AUTHORITY_LIFE.as_secs();
        Ok(Self { name, permitted: permitted.clone(), expires_s, certificate, key: key.serialize_pem() })
    }
}

fn authority_params(name: &str, permitted: &BTreeSet<String>) -> CertificateParams {
    let mut params = CertificateParams::default();
    params.distinguished_name = common_name(name);
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    params.name_constraints = Some(NameConstraints {
        permitted_subtrees: permitted.iter().cloned().map(GeneralSubtree::DnsName).collect(),
        excluded_subtrees: Vec::new(),
    });
    params
}

fn common_name(name: &str) -> DistinguishedName {
    let mut names = DistinguishedName::new();
    names.push(DnType::CommonName, name);
    names
}

/// SHA-256 of a certificate: pairs of hexadecimal digits with colons.
fn fingerprint(certificate: &CertificateDer<'_>) -> String {
    let pairs: Vec<_> =
        digest(&SHA256, certificate).as_ref().iter().map(|byte| format!("{byte:02X}")).collect();
    pairs.join(":")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(texts: &[&str]) -> BTreeSet<String> {
        texts.iter().map(|&text| text.to_owned()).collect()
    }

    #[test]
    fn an_authority_is_made_once_for_its_owner_alone_and_again_at_its_end() {
        let folder = std::env::temp_dir().join(format!("barrelman-authority-{}", std::process::id()));
        let path = folder.join("below/authority.json");
        let now = SystemTime::now();
        let kept =
            |at| Authority::kept_in(&path, &names(&["localhost"]), at).map(|one| one.shown.fingerprint);
        let first = kept(now).unwrap();
        assert!(!is_readable_by_others(&path) && first.len() == 95, "{first}");
        assert_eq!(kept(now + 720 * DAY).unwrap(), first);
        let later = kept(now + 724 * DAY).unwrap();
        assert_ne!(later, first);
        assert_eq!(kept(now + 724 * DAY).unwrap(), later);
        fs::write(&path, "{}").unwrap();
        let error = format!("{:#}", kept(now).unwrap_err());
        assert!(error.contains("remove the file"), "{error}");
        fs::write(&path, "").unwrap();
        assert!(kept(now).is_ok(), "a killed program's empty file is replaced");
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn an_authority_permits_its_names_and_all_addresses() {
        let text =
            serde_json::to_vec(&Kept::make(&names(&["local", "boat.example"]), SystemTime::now()).unwrap());
        let authority = Authority::parse(&text.unwrap()).unwrap();
        for (name, is_permitted) in [
            ("laptop.local", true),
            ("boat.example", true),
            ("my.boat.example", true),
            ("notboat.example", false),
            ("bank.example", false),
            ("192.168.1.7", true),
            ("fe80::1", true),
        ] {
            assert_eq!(authority.permits(name), is_permitted, "{name}");
        }
    }
}
