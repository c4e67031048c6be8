//! The arguments of `config`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// `config`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman config example > barrelman.toml\n  barrelman config print barrelman.toml"
)]
pub struct ConfigArgs {
    /// What to print.
    #[command(subcommand)]
    pub command: ConfigCommand,
}

/// What `config` prints.
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// An example with every key, its unit, range and default.
    #[command(after_help = "Example:\n  barrelman config example > barrelman.toml")]
    Example,
    /// The JSON schema, for editors.
    #[command(after_help = "Example:\n  barrelman config schema > barrelman.schema.json")]
    Schema,
    /// The OpenAPI document of the console's interface for programs, with its JSON schemas (docs/api.md).
    #[command(after_help = "Example:\n  barrelman config api > api.openapi.json")]
    Api,
    /// The effective configuration, complete.
    #[command(after_help = "Example:\n  barrelman config print barrelman.toml")]
    Print {
        /// Configuration file (TOML); default: the defaults alone.
        config: Option<PathBuf>,
    },
}
