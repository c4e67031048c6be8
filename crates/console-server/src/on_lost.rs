//! What happens when the controlling page is gone.

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What happens when the controlling page is gone: closed for two seconds, or silent for three.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnConsoleLost {
    /// An engaged camera stays engaged.
    #[default]
    Stay,
    /// The camera stops.
    Stop,
}
