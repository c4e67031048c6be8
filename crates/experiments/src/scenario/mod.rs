//! Scenario files (TOML), read and converted to [`barrelman_sim::Scenario`].
//!
//! The folder `config/scenarios` holds the built-in scenarios with their documentation. Any file of the same
//! form can be used. An error shows the line of the mistake.

mod built_in;
mod choice;
mod load;
mod loaded;
mod printed;

pub mod file;
pub mod resolve;

pub mod error;
mod range;

pub use built_in::{BUILT_IN, BUILT_IN_PATHS, BuiltIn};
pub use choice::{ScenarioChoice, choices, require_choice};
pub use error::ScenarioError;
pub use load::load;
pub use loaded::{LoadedScenario, ScenarioOverrides};
pub use printed::complete;
