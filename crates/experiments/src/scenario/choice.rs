//! The scenarios that a person can choose from.

use anyhow::{Result, bail};
use schemars::JsonSchema;
use serde::Serialize;

use super::built_in::BUILT_IN;
use super::file::ScenarioFile;
use super::load::load;
use super::loaded::ScenarioOverrides;

/// A scenario that can be chosen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ScenarioChoice {
    /// The name of a built-in scenario, or the path of the session's own file.
    pub name: String,
    /// One line about the scenario.
    pub summary: String,
}

/// The built-in scenarios, and the session's own where that is a file.
///
/// # Errors
/// The session's scenario cannot be read.
pub fn choices(own: &str) -> Result<Vec<ScenarioChoice>> {
    let built_in = BUILT_IN.iter().map(|built_in| built_in.name);
    let file = (!built_in.clone().any(|name| name == own)).then_some(own);
    let choice = |name: &str| {
        let file: ScenarioFile = toml::from_str(&load(name, &ScenarioOverrides::default())?.text)?;
        Ok(ScenarioChoice { name: name.to_owned(), summary: file.summary })
    };
    built_in.chain(file).map(choice).collect()
}

/// Checks that a scenario is one of the choices: a request names no file of this machine.
///
/// # Errors
/// The scenario is none of them.
pub fn require_choice(name: &str, choices: &[ScenarioChoice]) -> Result<()> {
    if choices.iter().any(|choice| choice.name == name) {
        return Ok(());
    }
    let names: Vec<&str> = choices.iter().map(|choice| choice.name.as_str()).collect();
    bail!("there is no scenario {name:?}: use one of {}", names.join(", "))
}
