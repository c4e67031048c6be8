//! Scenarios: TOML at the edge, [`barrelman_sim::Scenario`] inside.
//!
//! The built-in scenarios lie in `config/scenarios`, documented; any file of the same form can be used. A mistake in a
//! file is shown with its line.

mod built_in;
mod load;
mod loaded;

pub mod file;
pub mod resolve;

pub mod error;
mod range;

pub use built_in::{BUILT_IN, BuiltIn, PATHS};
pub use error::ScenarioError;
pub use load::load;
pub use loaded::{LoadedScenario, ScenarioOverrides};
