//! Measures the simulator against the laboratory's recorded trials, and what is required of it.
//!
//! The recorded trials may not be handed on, so they lie beside the repository.

mod believable;
mod fit;
mod motion;
mod recorded;

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use crate::root;

/// Options of `acceptance sim`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// The folder of recorded trials [default: ../shared/data/trials beside the workspace].
    #[arg(long, value_name = "DIR")]
    pub(crate) trials: Option<PathBuf>,
    /// Simulated trials of each arena.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) seeds: u64,
    /// The first of them: nothing was tuned on those from 10,000 on.
    #[arg(long, value_name = "SEED", default_value_t = 10_000)]
    pub(crate) first_seed: u64,
}

/// Options of `fit-target`.
#[derive(Debug, Clone, Args)]
pub(crate) struct FitOptions {
    /// The folder of recorded trials [default: ../shared/data/trials beside the workspace].
    #[arg(long, value_name = "DIR")]
    pub(crate) trials: Option<PathBuf>,
    /// Which arena's target.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(crate) arena: u8,
    /// Candidates that are tried.
    #[arg(long, value_name = "N", default_value_t = 600)]
    pub(crate) rounds: u64,
    /// Simulated trials for each, with the seeds from 1 on.
    #[arg(long, value_name = "N", default_value_t = 40)]
    pub(crate) seeds: u64,
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
pub(crate) fn acceptance(options: &Options) -> Result<bool> {
    let folder = trials_folder(options.trials.as_ref())?;
    believable::run(&folder, options.first_seed, options.seeds)
}

/// Fits the target's motion.
///
/// # Errors
/// If recorded trials or scenarios cannot be used.
pub(crate) fn fit_target(options: &FitOptions) -> Result<bool> {
    let folder = trials_folder(options.trials.as_ref())?;
    fit::run(&folder, options.arena, options.rounds, options.seeds)
}
