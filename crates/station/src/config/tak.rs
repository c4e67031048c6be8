//! Events of Cursor on Target in the configuration.

use anyhow::{Context as _, Result, bail};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tak::TakAddress;

/// Begins the names on the map unless another name is given.
const CALLSIGN: &str = "Barrelman";
/// Longest callsign, characters: displays cut longer ones off.
const MAX_CALLSIGN: usize = 32;

/// Boat, camera and marks on the maps of TAK displays.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TakSection {
    /// Where events of Cursor on Target go: `udp://host:port`, also of a multicast group, or
    /// `tcp://host:port`, a server; without an address none are sent.
    #[schemars(example = "udp://239.2.3.1:6969")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<String>,
    /// The names of boat, camera and marks on the map begin with this, at most 32 characters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub callsign: Option<String>,
}

/// The effective settings of events for TAK.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TakConfig {
    /// Where events go; `None`: none are sent.
    pub address: Option<TakAddress>,
    /// The names on the map begin with this.
    pub callsign: String,
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
        Ok(TakConfig { address: address.context("--tak, or tak.address")?, callsign: callsign.to_owned() })
    }

    /// A complete section.
    pub(super) fn from_config(config: &TakConfig) -> Self {
        Self {
            address: config.address.as_ref().map(ToString::to_string),
            callsign: Some(config.callsign.clone()),
        }
    }
}
