//! The evaluation: measures trackers, the simulator and the camera laws against their requirements, fits and tunes, and
//! renders views to look at.
//!
//! ```text
//! cargo run --release -p barrelman-eval -- tracker|simulator|law|tune|views|fit
//! ```
//! A command that judges requirements exits with 1 where a requirement is missed.

mod tracker;

mod simulator;

mod law;

mod views;

mod svg;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(name = "barrelman-eval", max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure the tracker on real clips and generated scenes: accuracy, confidence, cost.
    Tracker(tracker::Options),
    /// Compare simulated trials with recorded ones.
    Simulator(simulator::Options),
    /// Compare the camera laws on the same seeds.
    Law(law::Options),
    /// Search for parameters of the optimal law.
    Tune(law::TuneOptions),
    /// Render named views of the simulator as PNG files.
    Views(views::Options),
    /// Fit the motion of the simulated laboratory target to the recorded trials.
    Fit(simulator::FitOptions),
}

fn main() -> ExitCode {
    let (name, done) = match Cli::parse().command {
        Command::Tracker(options) => ("tracker", tracker::run(&options)),
        Command::Simulator(options) => ("simulator", simulator::run(&options)),
        Command::Law(options) => ("law", law::run(&options)),
        Command::Tune(options) => ("tune", law::tune(&options)),
        Command::Views(options) => ("views", views::render(&options)),
        Command::Fit(options) => ("fit", simulator::fit_target(&options)),
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

/// Prints a line of the result. A reader that has closed the output is no failure.
fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// The folder of the workspace.
fn root() -> Result<PathBuf> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    crates
        .and_then(Path::parent)
        .map(Path::to_path_buf)
        .context("the workspace lies two folders above this crate")
}
