//! `barrelman config`: prints the example, the JSON schema, or the effective configuration.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use anyhow::Result;

use crate::cli::{ConfigArgs, ConfigWhat};
use crate::config::{self, ConfigFile, Configuration};

/// Runs the command.
///
/// # Errors
/// If a file is not usable.
pub fn run(args: &ConfigArgs) -> Result<ExitCode> {
    let text = match &args.what {
        ConfigWhat::Example => config::EXAMPLE.to_owned(),
        ConfigWhat::Schema => config::schema()? + "\n",
        ConfigWhat::Print { config: None } => Configuration::resolve(&ConfigFile::default())?.to_toml()?,
        ConfigWhat::Print { config: Some(path) } => {
            Configuration::resolve(&config::read(path)?)?.to_toml()?
        }
    };
    stdout().write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}
