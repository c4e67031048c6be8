//! The rules of the house that a program can check: `cargo run -p xtask -- tidy`.
//!
//! `xtask` depends on no crate of ours, so that it runs in seconds and also while the code does not compile.

mod circles;
mod documents;
mod edges;
mod retired_names;

mod tracked_files;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments != ["tidy"] {
        say("usage: cargo run -p xtask -- tidy");
        return ExitCode::from(2);
    }
    match tidy() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            say(&format!("tidy: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// Whether nothing was found.
fn tidy() -> Result<bool> {
    let root = root()?;
    let mut findings = edges::check(&root)?;
    findings.extend(circles::check(&root)?);
    findings.extend(retired_names::check(&root)?);
    findings.extend(documents::check(&root)?);
    for finding in &findings {
        say(finding);
    }
    match findings.len() {
        0 => say("tidy: nothing found"),
        count => say(&format!("tidy: {count} findings")),
    }
    Ok(findings.is_empty())
}

/// Prints a line of the result. Who has stopped reading wants no more of it: that is no failure.
fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn root() -> Result<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().map(Path::to_path_buf).context("the workspace lies above xtask")
}
