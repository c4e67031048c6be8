//! Options of `barrelman-eval law` and `barrelman-eval tune`.

use anyhow::Result;
use barrelman_control::optimal::ModeTuning;
use barrelman_experiments::law_choice::ModeName;
use clap::Args;

use super::tuning_parameters;

/// Options of `law`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Trials of each condition.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) seeds: u64,
    /// The first seed: the search never used seeds from 20,000 on.
    #[arg(long, value_name = "SEED", default_value_t = 20_000)]
    pub(crate) first_seed: u64,
    /// Only conditions whose name begins so, or `robustness`, `vehicles`, `one-axis` or `two-axes` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    /// Only laws whose name begins so, such as `minimum-energy` or `LQG` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) law: Vec<String>,
    /// The mode of the tables `robustness` and `vehicles`, and of `--set`.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) mode: ModeName,
    /// Change a value of the mode (repeatable); the names are those that `tune` prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    /// Draw time outside against movement for several horizons of the intermittent mode, with the other laws as points.
    #[arg(long)]
    pub(crate) curve: bool,
}

/// Options of `tune`.
#[derive(Debug, Clone, Args)]
pub(crate) struct TuneOptions {
    /// The mode that is tuned.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) mode: ModeName,
    /// Tunings that are tried.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) rounds: u64,
    /// Trials of each condition for each tuning.
    #[arg(long, value_name = "N", default_value_t = 24)]
    pub(crate) seeds: u64,
    /// The first seed of the trials; seeds from 20,000 on are for judging.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(crate) first_seed: u64,
    /// Seed of the search.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(crate) search: u64,
    /// Only conditions whose name begins so, or variants: `vehicles`, `robustness`, or a row's name (repeatable). Without it
    /// all conditions and no variants.
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    /// Vary only this value (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) vary: Vec<String>,
    /// Change a value that the search begins with (repeatable); the names are those that it prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

impl Options {
    /// The tuning of the chosen mode with the changes.
    ///
    /// # Errors
    /// If a changed value does not exist.
    pub(super) fn tuning(&self) -> Result<ModeTuning> {
        tuning_parameters::with_changes(tuning_parameters::of_mode(self.mode).1, &self.set)
    }

    /// A mode's name in the tables, and its tuning: with the changes if the mode is the chosen one.
    ///
    /// # Errors
    /// If a changed value does not exist.
    pub(super) fn tuning_of(&self, mode: ModeName) -> Result<(&'static str, ModeTuning)> {
        let (name, tuning) = tuning_parameters::of_mode(mode);
        Ok((name, if mode == self.mode { self.tuning()? } else { tuning }))
    }

    /// Whether a condition is chosen.
    pub(super) fn includes_condition(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|prefix| name.starts_with(prefix.as_str()))
    }

    /// Whether another table is chosen.
    pub(super) fn includes_table(&self, table: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|name| name == table)
    }

    /// Whether a law is chosen.
    pub(super) fn includes_law(&self, name: &str) -> bool {
        self.law.is_empty() || self.law.iter().any(|prefix| name.starts_with(prefix.as_str()))
    }
}
