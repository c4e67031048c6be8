//! The configuration: a TOML file ([`ConfigFile`]) and the effective configuration ([`Configuration`]).
//!
//! Unknown keys are rejected. A key is declared once, in its section's type ([`file`]): words with the unit,
//! range, example. Schema, check of ranges and `config/barrelman.example.toml` follow from that; defaults
//! come from the vehicle's profile. The complete effective configuration is part of the first message of
//! every recording.

pub mod file;

pub mod camera;
pub mod console;
pub mod detector;
pub mod lens;
pub mod share;
pub mod speeds;
pub mod tak;
pub mod tracker;
pub mod tracking_camera;
pub mod vessel;

pub mod resolve;

pub mod changed_keys;

mod declared;
mod example;
mod field_names;
mod mavlink;
mod turning;
mod zoom;

use std::path::Path;

use anyhow::{Context, Result, anyhow};

use barrelman_experiments::toml_message::message_of;
use barrelman_host::input;
use barrelman_host::redaction::without_logins;

pub use console::{ConsoleConfig, RecordingConfig};
pub use file::{ConfigFile, LineEnding};
pub use resolve::Configuration;
pub use tak::TakConfig;
pub use tracking_camera::TrackingCameraConfig;

/// A configuration with a mistake: a service with it is not started again and again.
#[derive(Debug, thiserror::Error)]
#[error("{0} is not usable")]
pub struct UnusableConfiguration(pub String);

/// The documented example.
///
/// # Errors
/// Never in practice: the defaults are usable.
pub fn example() -> Result<String> {
    example::example()
}

/// Reads a configuration file, with the lens file that it names.
///
/// # Errors
/// If a file cannot be read or parsed, or the lens cannot be used; the message names the file, the line and
/// the key.
pub fn read(path: &Path) -> Result<ConfigFile> {
    let text = String::from_utf8(input::read(path)?);
    let parsed = text.context("it is not UTF-8 text").and_then(|text| parse(&text)).and_then(|mut file| {
        file.camera.read_lens()?;
        Ok(file)
    });
    parsed.with_context(|| UnusableConfiguration(format!("the configuration {}", path.display())))
}

/// Parses the text of a configuration file.
///
/// # Errors
/// If a key is unknown or a value has the wrong type; the message shows the line.
pub fn parse(text: &str) -> Result<ConfigFile> {
    // The message shows the line with the mistake, which may hold an address with a login.
    toml::from_str(text).map_err(|error| anyhow!("{}", without_logins(&message_of(&error))))
}

/// The JSON schema of a configuration file.
///
/// # Errors
/// Never in practice: the schema is plain data.
pub fn schema() -> Result<String> {
    Ok(serde_json::to_string_pretty(&declared::schema_of::<ConfigFile>())?)
}
