//! The annotated video for programs of others in the configuration.

use anyhow::{Context as _, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::share::ShareAddress;

/// The annotated live video for other programs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShareSection {
    /// Where the annotated video is served as RTSP with H.264: `rtsp://IP:PORT/PATH`; without an address it
    /// is not. Readers give the user `watch` and the console's watch token.
    #[schemars(example = "rtsp://0.0.0.0:8554/boat")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<String>,
}

impl ShareSection {
    /// Where the annotated video is served; `None`: nowhere.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub(super) fn resolve(&self) -> Result<Option<ShareAddress>> {
        let address = self.address.as_deref().map(ShareAddress::parse).transpose();
        address.context("--share, or share.address")
    }

    /// A complete section.
    pub(super) fn from_config(address: Option<&ShareAddress>) -> Self {
        Self { address: address.map(ToString::to_string) }
    }
}
