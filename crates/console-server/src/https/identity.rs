//! Which certificate a connection gets.
//!
//! A certificate of the own authority is for the names of the machine and for the addresses by which
//! connections came. It is issued anew for an address that is new (another network, after the start), and
//! when half of its life is over.

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use anyhow::{Context as _, Result};
use rustix::system::uname;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::{CertificateDer, DnsName, PrivateKeyDer};

use super::authority::{Authority, CERTIFICATE_LIFE, LATE_CLOCK, PublicAuthority};
use super::given::CertificateFiles;

/// Addresses by which connections came, at most: a machine may have a whole network of IPv6.
const MAX_ADDRESSES: usize = 64;

/// What a server shows who it is with.
pub(crate) struct Identity(Source);

enum Source {
    Given(Arc<ServerConfig>),
    Issued(Box<Own>),
}

struct Own {
    authority: Authority,
    /// Names without the addresses.
    names: BTreeSet<String>,
    issued: Mutex<Issued>,
}

struct Issued {
    addresses: BTreeSet<String>,
    at: SystemTime,
    config: Arc<ServerConfig>,
}

impl Identity {
    /// The certificate of files.
    ///
    /// # Errors
    /// If the files cannot be used.
    pub(crate) fn given(files: &CertificateFiles) -> Result<Self> {
        let (chain, key) = files.read()?;
        let (certificate, key_file) = (files.certificate.display(), files.key.display());
        let config = config_of(chain, key).with_context(|| {
            format!("the certificate {certificate} cannot be used with the key {key_file}")
        })?;
        Ok(Self(Source::Given(config)))
    }

    /// A certificate of the authority that is kept in a file, for the names of this machine and `host_names`.
    ///
    /// # Errors
    /// If the authority cannot be read or made.
    pub(crate) fn own(
        kept_in: &Path,
        listens_on: IpAddr,
        host_names: &[String],
        now: SystemTime,
    ) -> Result<Self> {
        let mut names = machine_names(host_names);
        let is_dns = |name: &&String| name.parse::<IpAddr>().is_err();
        let permitted = names.iter().filter(is_dns).cloned().chain(["local".to_owned()]).collect();
        let authority = Authority::kept_in(kept_in, &permitted, now)?;
        names.retain(|name| {
            let is_permitted = authority.permits(name);
            if !is_permitted {
                tracing::warn!(
                    "the console's certificate is not for {name}, which is newer than the authority: to open the page by that name, \
                     remove {}; each device has to trust the new authority",
                    kept_in.display()
                );
            }
            is_permitted
        });
        let addresses =
            if listens_on.is_unspecified() { BTreeSet::new() } else { [text_of(listens_on)].into() };
        let issued = Issued::new(&authority, &names, addresses, now)?;
        Ok(Self(Source::Issued(Box::new(Own { authority, names, issued: Mutex::new(issued) }))))
    }

    /// The configuration for a connection to this address of the machine.
    ///
    /// # Errors
    /// If no certificate can be issued.
    pub(super) fn config_for(&self, reached: IpAddr, now: SystemTime) -> Result<Arc<ServerConfig>> {
        match &self.0 {
            Source::Given(config) => Ok(Arc::clone(config)),
            Source::Issued(own) => own.config_for(text_of(reached), now),
        }
    }

    /// The names, besides addresses, that a certificate of the own authority is for.
    pub(crate) fn names(&self) -> impl Iterator<Item = &String> {
        let names = match &self.0 {
            Source::Given(_) => None,
            Source::Issued(own) => Some(&own.names),
        };
        names.into_iter().flatten()
    }

    /// The program's own authority, if the certificate is of it.
    pub(crate) fn authority(&self) -> Option<&PublicAuthority> {
        match &self.0 {
            Source::Given(_) => None,
            Source::Issued(own) => Some(own.authority.shown()),
        }
    }
}

impl Own {
    fn config_for(&self, address: String, now: SystemTime) -> Result<Arc<ServerConfig>> {
        let mut issued = self.issued.lock().unwrap_or_else(PoisonError::into_inner);
        let is_valid = issued.at - LATE_CLOCK / 2 <= now && now < issued.at + CERTIFICATE_LIFE / 2;
        if !is_valid || !issued.addresses.contains(&address) {
            let mut addresses = issued.addresses.clone();
            if addresses.len() >= MAX_ADDRESSES {
                addresses.clear();
            }
            addresses.insert(address);
            *issued = Issued::new(&self.authority, &self.names, addresses, now)?;
        }
        Ok(Arc::clone(&issued.config))
    }
}

impl Issued {
    fn new(
        authority: &Authority,
        names: &BTreeSet<String>,
        addresses: BTreeSet<String>,
        at: SystemTime,
    ) -> Result<Self> {
        let all = names.union(&addresses).cloned().collect();
        let (chain, key) = authority.issue(&all, at).context("the console's certificate cannot be issued")?;
        Ok(Self { addresses, at, config: config_of(chain, key)? })
    }
}

/// TLS 1.2 and 1.3 with the library's defaults, and HTTP/1.1 in it.
fn config_of(chain: Vec<CertificateDer<'static>>, key: PrivateKeyDer<'static>) -> Result<Arc<ServerConfig>> {
    let mut config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()?
        .with_no_client_auth()
        .with_single_cert(chain, key)?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(Arc::new(config))
}

/// The names by which this machine is reached: loopback, the name of the machine, and these, without their
/// ports.
fn machine_names(host_names: &[String]) -> BTreeSet<String> {
    let machine = uname().nodename().to_string_lossy().into_owned();
    let names = [machine.clone(), format!("{machine}.local"), "localhost".to_owned(), "127.0.0.1".to_owned()];
    let names = names.into_iter().chain(host_names.iter().map(|name| without_port(name).to_owned()));
    let names = names.map(|name| name.to_ascii_lowercase());
    names.filter(|name| name.parse::<IpAddr>().is_ok() || DnsName::try_from(name.as_str()).is_ok()).collect()
}

fn without_port(name: &str) -> &str {
    let name = match name.rsplit_once(':') {
        Some((before, port)) if port.parse::<u16>().is_ok() && name.parse::<IpAddr>().is_err() => before,
        _ => name,
    };
    name.trim_start_matches('[').trim_end_matches(']')
}

fn text_of(address: IpAddr) -> String {
    address.to_canonical().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_certificate_is_for_the_machine_and_for_the_names_of_the_configuration() {
        let hosts = ["Boat.Example:8443", "192.168.1.7:8480", "[fd00::1]:8480", "fd00::2", "no name", "öst"];
        let names = machine_names(&hosts.map(str::to_owned));
        for name in ["localhost", "127.0.0.1", "boat.example", "192.168.1.7", "fd00::1", "fd00::2"] {
            assert!(names.contains(name), "{name} in {names:?}");
        }
        assert!(!names.contains("no name") && !names.contains("öst"), "{names:?}");
    }

    #[test]
    fn a_certificate_is_issued_again_for_a_new_address_and_in_time() {
        let path = std::env::temp_dir().join(format!("barrelman-identity-{}", std::process::id()));
        let now = SystemTime::now();
        let loopback = [127, 0, 0, 1].into();
        let identity = Identity::own(&path, loopback, &[], now).unwrap();
        let config = |address: [u8; 4], at| identity.config_for(address.into(), at).unwrap();
        let first = config([127, 0, 0, 1], now);
        assert!(Arc::ptr_eq(&first, &config([127, 0, 0, 1], now + CERTIFICATE_LIFE / 3)));
        let second = config([192, 168, 1, 7], now);
        assert!(!Arc::ptr_eq(&first, &second));
        assert!(Arc::ptr_eq(&second, &config([127, 0, 0, 1], now)), "for both addresses");
        let later = now + CERTIFICATE_LIFE / 2;
        assert!(!Arc::ptr_eq(&second, &config([127, 0, 0, 1], later)), "before its end");
        assert!(
            !Arc::ptr_eq(&config([127, 0, 0, 1], later), &config([127, 0, 0, 1], now)),
            "a clock that was wrong"
        );
        for last in 0..=255 {
            config([10, 0, 0, last], now);
        }
        let Source::Issued(own) = &identity.0 else { panic!("an own authority") };
        assert!(own.issued.lock().unwrap().addresses.len() <= MAX_ADDRESSES);
        std::fs::remove_file(&path).unwrap();
    }
}
