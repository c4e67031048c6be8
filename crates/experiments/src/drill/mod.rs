//! Drills: short tasks in simulated worlds, each with a result, and beside it what the camera laws would have
//! done with the same boat.

mod figures;
mod judge;
mod plan;
mod reference;

use barrelman_vocab::DrillName;
use schemars::JsonSchema;
use serde::Serialize;

pub use figures::DrillFigures;
pub use judge::DrillJudge;
pub use plan::DrillPlan;

/// The state of a drill.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DrillState {
    /// The drill.
    pub name: DrillName,
    /// The seed of its world.
    pub seed: u64,
    /// Time that is left, seconds; 0 at the end.
    pub left_s: f64,
    /// Whether the drill's own alarm is raised.
    pub alarm: bool,
    /// The result, at the end.
    pub result: Option<DrillResult>,
}

/// The result of a drill.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DrillResult {
    /// Whether the task was done.
    pub passed: bool,
    /// The result in words.
    pub sentence: String,
    /// The figures of the drill as it was done.
    pub person: DrillFigures,
    /// Those of the paper's motor schema, with perfect sight, from the world's start on.
    pub schema: DrillFigures,
    /// Those of the default law, likewise.
    pub default_law: DrillFigures,
}
