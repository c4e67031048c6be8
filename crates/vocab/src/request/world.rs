//! Requests about a simulated world.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

use crate::drill::DrillName;

/// A request about a simulated world, of which the pilot knows nothing: refused where
/// there is none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum WorldRequest {
    /// Pause the time of the world; in the demo only.
    Pause,
    /// Resume the time of the world; in the demo only.
    Resume,
    /// End this world and begin another. This is a stop: the new drive begins disengaged and without marks.
    NewDrive(NewDrive),
    /// End this world and begin a drill in another one; in the demo only. This is a stop.
    Drill(NewDrill),
}

/// The world of a new drive.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewDrive {
    /// The scenario: one of `hello.scenarios`.
    pub scenario: String,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// The drill that begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewDrill {
    /// The drill.
    pub drill: DrillName,
    /// Seed of all random numbers.
    pub seed: u64,
}
