//! Measures the camera laws against each other, on the same seeds: what is required of the optimal law, and its tuning.

mod conditions;
mod lqg;
mod mpc;
mod outlook;
mod robustness;
mod table;
mod tune;

use anyhow::Result;
use barrelman_control::optimal::Tuning;
use clap::Args;

use conditions::{CONDITIONS, Condition};

/// Options of `acceptance law`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Trials of each condition.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) seeds: u64,
    /// The first of them: the search never used those from 20,000 on.
    #[arg(long, value_name = "SEED", default_value_t = 20_000)]
    pub(crate) first_seed: u64,
    /// Only conditions whose name begins so, or `robustness` or `vehicles` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    /// Only laws whose name begins so, such as `minimum-energy` or `LQG` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) law: Vec<String>,
    /// ScenarioOverrides a value of `minimum-energy` (repeatable); the names are those that tune-law prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

/// Options of `tune-law`.
#[derive(Debug, Clone, Args)]
pub(crate) struct TuneOptions {
    /// The mode that is tuned.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) mode: barrelman_experiments::law_choice::ModeName,
    /// Settings that are tried.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) rounds: u64,
    /// Trials of each condition for each, with the seeds from 1 on.
    #[arg(long, value_name = "N", default_value_t = 24)]
    pub(crate) seeds: u64,
    /// Seed of the search.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(crate) search: u64,
    /// ScenarioOverrides a value that the search begins with (repeatable); the names are those that it prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

/// Measures the optimal law; whether every requirement holds.
///
/// # Errors
/// If scenarios cannot be used.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let chosen: Vec<&Condition> = CONDITIONS
        .iter()
        .filter(|condition| {
            options.only.is_empty()
                || options.only.iter().any(|name| condition.name().starts_with(name.as_str()))
        })
        .collect();
    let candidate = tune::with(Tuning::MINIMUM_ENERGY, &options.set)?;
    let mut holds = table::print(&chosen, options, &candidate)?;
    if options.only.is_empty() || options.only.iter().any(|name| name == "robustness") {
        holds &= robustness::print(options.first_seed, options.seeds, &candidate)?;
    }
    if options.only.is_empty() || options.only.iter().any(|name| name == "vehicles") {
        holds &= robustness::print_vehicles(options.first_seed, options.seeds, &candidate)?;
    }
    Ok(holds)
}

/// Searches for a tuning.
///
/// # Errors
/// If scenarios cannot be used.
pub(crate) fn tune(options: &TuneOptions) -> Result<bool> {
    tune::run(options)
}
