//! Rules that are executed, not remembered: `cargo run -p xtask -- tidy`.

mod documents;
mod edges;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};

fn main() -> ExitCode {
    match run() {
        Ok(findings) if findings.is_empty() => {
            say("tidy: nothing found");
            ExitCode::SUCCESS
        }
        Ok(findings) => {
            for finding in &findings {
                say(finding);
            }
            say(&format!("tidy: {} findings", findings.len()));
            ExitCode::FAILURE
        }
        Err(error) => {
            say(&format!("tidy: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<Vec<String>> {
    let command = std::env::args().nth(1);
    if command.as_deref() != Some("tidy") {
        bail!("use: cargo run -p xtask -- tidy");
    }
    let root = root()?;
    let mut findings = edges::check(&root)?;
    findings.extend(documents::check(&root)?);
    Ok(findings)
}

#[allow(clippy::print_stdout, reason = "the findings are this tool's result")]
fn say(text: &str) {
    println!("{text}");
}

fn root() -> Result<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().map(Path::to_path_buf).context("the workspace lies above xtask")
}
