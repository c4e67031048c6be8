//! Measures the simulator against the laboratory's recorded trials, and what is required of it.
//!
//! The recorded trials may not be handed on, so they lie beside the repository.

mod believable;
mod picture;

mod noise;

mod distance;

mod jumps;

mod rate;

mod centring;

mod pace;

mod speed;

mod fit;

mod motion;
mod recorded;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};

use crate::root;

/// Options of `acceptance sim`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// The folder of recorded trials [default: ../shared/data/trials beside the workspace].
    #[arg(long, value_name = "DIR")]
    pub(crate) trials: Option<PathBuf>,
    /// A folder with `lab1.toml` and `lab2.toml` to use in place of the program's own.
    #[arg(long, value_name = "DIR")]
    pub(crate) scenarios: Option<PathBuf>,
    /// This table only.
    #[arg(long, value_name = "TABLE")]
    pub(crate) only: Option<TableName>,
    /// Simulated trials of each arena.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) seeds: u64,
    /// The first of them: nothing was tuned on those from 10,000 on.
    #[arg(long, value_name = "SEED", default_value_t = 10_000)]
    pub(crate) first_seed: u64,
}

/// A table of `acceptance sim`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableName {
    /// Whether simulated trials are like the recorded ones: the one that is judged.
    Believable,
    /// How much the tracked place jitters.
    Noise,
    /// How fast the target goes where it is far, and where it is near.
    Distance,
    /// Whether the target stays in the picture.
    Picture,
    /// The published sensitivities, and the jumps of the authors' tracker.
    Jumps,
    /// What the schema's rate does.
    Rate,
    /// The schema against centring.
    Centre,
    /// What speed of the boat the laws can hold.
    Speed,
    /// How much faster than real time trials run.
    Pace,
}

/// Options of `fit-target`.
#[derive(Debug, Clone, Args)]
pub(crate) struct FitOptions {
    /// The folder of recorded trials [default: ../shared/data/trials beside the workspace].
    #[arg(long, value_name = "DIR")]
    pub(crate) trials: Option<PathBuf>,
    /// A folder with `lab1.toml` and `lab2.toml` to use in place of the program's own.
    #[arg(long, value_name = "DIR")]
    pub(crate) scenarios: Option<PathBuf>,
    /// Which arena's target.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(crate) arena: u8,
    /// Searches, the first from what the file has, the others from anywhere.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(crate) starts: u64,
    /// Generations of each, of 16 candidates.
    #[arg(long, value_name = "N", default_value_t = 60)]
    pub(crate) generations: u64,
    /// Simulated trials for each candidate, with seeds below 10,000.
    #[arg(long, value_name = "N", default_value_t = 96, value_parser = clap::value_parser!(u64).range(2..1_000))]
    pub(crate) seeds: u64,
    /// Candidates that are judged at the same time.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(crate) threads: usize,
}

fn trials_folder(given: Option<&PathBuf>) -> Result<PathBuf> {
    Ok(match given {
        Some(folder) => folder.clone(),
        None => root()?.join("../shared/data/trials"),
    })
}

/// Measures the simulator; whether every requirement that was judged holds.
///
/// # Errors
/// If recorded trials or scenarios cannot be used.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let folder = trials_folder(options.trials.as_ref())?;
    let wanted = |table| options.only.is_none_or(|only| only == table);
    if wanted(TableName::Noise) {
        noise::run(&folder, options)?;
    }
    if wanted(TableName::Distance) {
        distance::run(&folder, options)?;
    }
    if wanted(TableName::Picture) {
        picture::run(&folder, options)?;
    }
    if wanted(TableName::Jumps) {
        jumps::run(&folder, options)?;
    }
    if wanted(TableName::Rate) {
        rate::run(options)?;
    }
    if wanted(TableName::Centre) {
        centring::run(options)?;
    }
    if wanted(TableName::Speed) {
        speed::run(options)?;
    }
    if wanted(TableName::Pace) {
        pace::run(options)?;
    }
    if wanted(TableName::Believable) { believable::run(&folder, options) } else { Ok(true) }
}

/// Fits the target's motion.
///
/// # Errors
/// If recorded trials or scenarios cannot be used.
pub(crate) fn fit_target(options: &FitOptions) -> Result<bool> {
    let folder = trials_folder(options.trials.as_ref())?;
    fit::run(&folder, options)
}
