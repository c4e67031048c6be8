//! The configuration: TOML at the edge, plain structs inside.
//!
//! Unknown keys are rejected; every key has a unit, a range and a default, documented in
//! `config/barrelman.example.toml`. What is left out takes the default of the vehicle's profile. The effective
//! configuration, with nothing left out, is the first message of every recording.

pub mod camera;
pub mod file;
mod range;
pub mod resolve;
pub mod tracker;

use std::path::Path;

use anyhow::{Context, Result, anyhow};

use barrelman_experiments::law_choice::LawName;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_host::input;
use barrelman_host::redaction::without_logins;

pub use file::{ConfigFile, LineEnding};
pub use resolve::Configuration;

/// The documented example.
pub const EXAMPLE: &str = include_str!("../../../../config/barrelman.example.toml");

/// Reads a configuration file.
///
/// # Errors
/// If it cannot be read or understood; the message names the file, the line and the key.
pub fn read(path: &Path) -> Result<ConfigFile> {
    let text = String::from_utf8(input::read(path)?);
    let parsed = text.context("it is no text").and_then(|text| parse(&text));
    parsed.with_context(|| format!("the configuration {} is not usable", path.display()))
}

/// Reads a configuration from its text.
///
/// # Errors
/// If a key is unknown or a value has another type; the message points at it.
pub fn parse(text: &str) -> Result<ConfigFile> {
    // The message shows the line with the mistake, which may be that of an address with a login.
    toml::from_str(text).map_err(|error| anyhow!("{}", without_logins(&error.to_string())))
}

/// Reads the configuration that a recording begins with. One that names no tracker was made when CamShift was the
/// only one, and one that names no law when the schema was.
///
/// # Errors
/// If a key is unknown or a value has another type; the message points at it.
pub fn parse_recorded(text: &str) -> Result<ConfigFile> {
    let mut file = parse(text)?;
    file.tracker.name.get_or_insert(TrackerName::Camshift);
    file.law.name.get_or_insert(LawName::MotorSchema);
    Ok(file)
}

/// The JSON schema of a configuration file.
///
/// # Errors
/// Never in practice: the schema is plain data.
pub fn schema() -> Result<String> {
    Ok(serde_json::to_string_pretty(&schemars::schema_for!(ConfigFile))?)
}
