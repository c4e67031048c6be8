//! `barrelman links`: where the console of the running service is, with the tokens.

use std::process::ExitCode;

use anyhow::Result;
use barrelman_console_server::print_served;

use crate::cli::LinksArgs;

/// Runs the command.
///
/// # Errors
/// If no service runs, or this user may not read its links.
pub fn run(args: &LinksArgs) -> Result<ExitCode> {
    print_served(&args.file)?;
    Ok(ExitCode::SUCCESS)
}
