//! `barrelman config`: prints the example, the JSON schema, or the effective configuration.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use anyhow::Result;

use crate::cli::{ConfigArgs, ConfigCommand};
use crate::config::{self, ConfigFile, Configuration};
use barrelman_console_server::api::api_document;

/// Runs the command.
///
/// # Errors
/// If a file is not usable.
pub fn run(args: &ConfigArgs) -> Result<ExitCode> {
    let text = match &args.command {
        ConfigCommand::Example => config::example()?,
        ConfigCommand::Schema => config::schema()? + "\n",
        ConfigCommand::Api => serde_json::to_string_pretty(&api_document())? + "\n",
        ConfigCommand::Print { config: None } => Configuration::resolve(&ConfigFile::default())?.to_toml()?,
        ConfigCommand::Print { config: Some(path) } => {
            Configuration::resolve(&config::read(path)?)?.to_toml()?
        }
    };
    stdout().write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}
