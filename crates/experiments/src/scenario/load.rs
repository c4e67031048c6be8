//! Finds a scenario by its name or its path and reads it.

use std::path::Path;

use anyhow::{Result, bail};
use barrelman_host::input;

use super::built_in::BUILT_IN;
use super::loaded::{LoadedScenario, ScenarioOverrides};
use super::resolve;

/// The built-in scenario of this name, or the scenario file at this path.
///
/// # Errors
/// The scenario does not exist or has a mistake; the message shows its line.
pub fn load(name: &str, overrides: &ScenarioOverrides) -> Result<LoadedScenario> {
    if let Some(built_in) = BUILT_IN.iter().find(|built_in| built_in.name == name) {
        return Ok(resolve::read(built_in.text, overrides)
            .map_err(|error| error.located_in(&format!("the scenario {name}"), built_in.text))?);
    }
    if !name.ends_with(".toml") {
        let names: Vec<&str> = BUILT_IN.iter().map(|built_in| built_in.name).collect();
        bail!(
            "there is no scenario {name:?}: use one of {}, or the path of a file that ends in .toml \
             (`barrelman scenarios` lists them, `barrelman scenarios NAME` prints one)",
            names.join(", ")
        );
    }
    let bytes = input::read(Path::new(name))?;
    let Ok(text) = String::from_utf8(bytes) else { bail!("{name} is no scenario: it is not text") };
    Ok(resolve::read(&text, overrides).map_err(|error| error.located_in(name, &text))?)
}
