//! Requests about who has the control.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

/// A request about who has the control: a page, or the programs without a socket, which are one client
/// together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum SeatRequest {
    /// Take the control, also from another client, which the program tells.
    TakeControl,
    /// Ask for the control: who is in control may give it. An empty seat is taken at once.
    AskControl,
    /// Give the control to another client.
    GiveControl {
        /// Number of the other client (`control.clients`; a page's own is `hello.client`).
        client: u64,
    },
    /// Give the control up. A client that asks gets it.
    ReleaseControl,
}
