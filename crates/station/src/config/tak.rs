//! Events of Cursor on Target in the configuration.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::secrets::{ClientFiles, TrustFiles};
use crate::tak::{TakAddress, Transport};

/// Begins the names on the map unless another name is given.
const CALLSIGN: &str = "Barrelman";
/// Longest callsign, characters: displays cut longer ones off.
const MAX_CALLSIGN: usize = 32;

/// Boat, camera and marks on the maps of TAK displays.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TakSection {
    /// Where events of Cursor on Target go: `udp://host:port`, also of a multicast group, or
    /// `tcp://host:port` or `tls://host:port`, a server; without an address none are sent.
    #[schemars(example = "udp://239.2.3.1:6969")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<String>,
    /// The names of boat, camera and marks on the map begin with this, at most 32 characters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub callsign: Option<String>,
    /// File of authorities (PEM) that sign the certificate of a server at `tls://`; default: the well-known
    /// authorities.
    #[schemars(example = "/etc/barrelman/tak-authority.pem")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ca_file: Option<PathBuf>,
    /// Own certificate for a server at `tls://` that asks for one (PEM, with those of the authorities above
    /// it).
    #[schemars(example = "/etc/barrelman/tak-client.pem")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub client_certificate: Option<PathBuf>,
    /// Key of the own certificate (PEM, not encrypted).
    #[schemars(example = "/etc/barrelman/tak-client.key")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub client_key: Option<PathBuf>,
}

/// The effective settings of events for TAK.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TakConfig {
    /// Where events go; `None`: none are sent.
    pub address: Option<TakAddress>,
    /// The names on the map begin with this.
    pub callsign: String,
    /// Which certificate of a server is accepted.
    pub trust: TrustFiles,
    /// The own certificate; `None`: there is none.
    pub client: Option<ClientFiles>,
}

impl TakSection {
    /// The effective settings.
    ///
    /// # Errors
    /// If the address or the callsign cannot be used.
    pub(super) fn resolve(&self) -> Result<TakConfig> {
        let address = self.address.as_deref().map(TakAddress::parse).transpose();
        let callsign = self.callsign.as_deref().unwrap_or(CALLSIGN);
        // U+FFFE and U+FFFF are no characters of XML.
        let is_text = |c: char| !c.is_control() && c < '\u{fffe}' || c > '\u{ffff}';
        let is_usable =
            callsign.chars().all(is_text) && (1..=MAX_CALLSIGN).contains(&callsign.chars().count());
        if !is_usable || callsign.trim() != callsign {
            bail!(
                "tak.callsign = {callsign:?}: use 1 to {MAX_CALLSIGN} characters in one line, without space at \
                 its ends"
            );
        }
        let address = address.context("--tak, or tak.address")?;
        let (trust, client) = self.tls(address.as_ref())?;
        Ok(TakConfig { address, callsign: callsign.to_owned(), trust, client })
    }

    /// The files of TLS.
    fn tls(&self, address: Option<&TakAddress>) -> Result<(TrustFiles, Option<ClientFiles>)> {
        let client = match (&self.client_certificate, &self.client_key) {
            (Some(certificate), Some(key)) => {
                Some(ClientFiles { certificate: certificate.clone(), key: key.clone() })
            }
            (None, None) => None,
            _ => bail!("tak.client_certificate and tak.client_key belong together: give both, or neither"),
        };
        let is_given = client.is_some() || self.ca_file.is_some();
        if let Some(address) = address.filter(|address| is_given && address.transport != Transport::Tls) {
            bail!("tak.ca_file and tak.client_certificate are about tls://, and events go to {address}");
        }
        Ok((TrustFiles { ca_file: self.ca_file.clone(), ..TrustFiles::default() }, client))
    }

    /// A complete section.
    pub(super) fn from_config(config: &TakConfig) -> Self {
        Self {
            address: config.address.as_ref().map(ToString::to_string),
            callsign: Some(config.callsign.clone()),
            ca_file: config.trust.ca_file.clone(),
            client_certificate: config.client.as_ref().map(|files| files.certificate.clone()),
            client_key: config.client.as_ref().map(|files| files.key.clone()),
        }
    }
}
