//! Requests about who has the control.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

/// A request about which page has the control. Only a page on a socket can make it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum SeatRequest {
    /// Take the control, also from another page, which the program tells.
    TakeControl,
    /// Ask the page in control for the control.
    AskControl,
    /// Give the control to another page.
    GiveControl {
        /// Number of the other page (`hello.client`).
        client: u64,
    },
}
