//! Rules that are executed, not remembered: `cargo run -p xtask -- tidy`; and requirements that are measured, not
//! asserted: `cargo run --release -p xtask -- acceptance tracker`; and pictures to be looked at:
//! `cargo run --release -p xtask -- views --output DIR`.

mod acceptance;

mod documents;
mod edges;

mod law;

mod simulation;
mod svg;
mod views;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(name = "xtask", max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Compares the code with what the documents promise.
    Tidy,
    /// Draws named views with the simulator's renderer, as PNG files to look at.
    Views(views::Options),
    /// Measures what was required, and exits with 1 where it is missed.
    Acceptance {
        #[command(subcommand)]
        part: Part,
    },
    /// Fits how the laboratory's simulated target moves to how the recorded ones moved.
    FitTarget(simulation::FitOptions),
    /// Searches for a tuning of the optimal law.
    TuneLaw(law::TuneOptions),
}

#[derive(Debug, Subcommand)]
enum Part {
    /// The tracker on real clips and generated scenes: how well it follows, and what it costs.
    Tracker(acceptance::Options),
    /// The simulator: whether its trials are like the recorded ones.
    Sim(simulation::Options),
    /// The camera laws, against each other.
    Law(law::Options),
}

fn main() -> ExitCode {
    let (name, done) = match Cli::parse().task {
        Task::Tidy => ("tidy", tidy()),
        Task::Views(options) => ("views", views::draw(&options)),
        Task::Acceptance { part: Part::Tracker(options) } => ("acceptance", acceptance::tracker(&options)),
        Task::Acceptance { part: Part::Sim(options) } => ("acceptance", simulation::acceptance(&options)),
        Task::Acceptance { part: Part::Law(options) } => ("acceptance", law::acceptance(&options)),
        Task::TuneLaw(options) => ("tune-law", law::tune(&options)),
        Task::FitTarget(options) => ("fit-target", simulation::fit_target(&options)),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            say(&format!("{name}: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// Whether nothing was found.
fn tidy() -> Result<bool> {
    let root = root()?;
    let mut findings = edges::check(&root)?;
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
