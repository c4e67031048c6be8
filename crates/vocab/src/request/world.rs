//! Requests about a simulated world.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

/// A request about a simulated world, of which the pilot knows nothing: in the demo only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum WorldRequest {
    /// Pause the time of the world.
    Pause,
    /// Resume the time of the world.
    Resume,
}
