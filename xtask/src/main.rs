//! Checks the rules of the repository that a program can check: `cargo run -p xtask -- tidy`. Prints the
//! licences of what programs consist of: `cargo run -p xtask -- licences PACKAGE...`.
//!
//! `xtask` depends on no crate of the workspace, so that it runs in seconds, also while the code does not
//! compile.

mod circles;
mod dependencies;
mod documents;
mod guard;
mod licences;

mod tracked_files;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match &arguments[..] {
        [command] if command == "tidy" => tidy(),
        [command, packages @ ..] if command == "licences" && !packages.is_empty() => licences(packages),
        _ => {
            print_line("usage: cargo run -p xtask -- tidy\n       cargo run -p xtask -- licences PACKAGE...");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Prints the licences of what these packages consist of.
fn licences(packages: &[String]) -> Result<bool> {
    let text = licences::text(&root()?, packages)?;
    std::io::stdout().write_all(text.as_bytes())?;
    Ok(true)
}

/// Runs all checks and prints the findings. Returns whether there are none.
fn tidy() -> Result<bool> {
    let root = root()?;
    let mut findings = dependencies::check(&root)?;
    findings.extend(guard::check(&root)?);
    findings.extend(circles::check(&root)?);
    findings.extend(documents::check(&root)?);
    for finding in &findings {
        print_line(finding);
    }
    match findings.len() {
        0 => print_line("tidy: nothing found"),
        count => print_line(&format!("tidy: {count} findings")),
    }
    Ok(findings.is_empty())
}

/// Prints a line of the result. A closed pipe is not an error.
fn print_line(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn root() -> Result<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    folder.parent().map(Path::to_path_buf).context("the workspace lies above xtask")
}
