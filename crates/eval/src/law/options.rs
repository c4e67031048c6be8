//! Options of `barrelman-eval law` and `barrelman-eval tune`.

use clap::Args;

/// Options of `law`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Trials of each condition.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) seeds: u64,
    /// The first seed: the search never used seeds from 20,000 on.
    #[arg(long, value_name = "SEED", default_value_t = 20_000)]
    pub(crate) first_seed: u64,
    /// Only conditions whose name begins so, or `robustness` or `vehicles` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    /// Only laws whose name begins so, such as `minimum-energy` or `LQG` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) law: Vec<String>,
    /// Change a value of `minimum-energy` (repeatable); the names are those that `tune` prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

/// Options of `tune`.
#[derive(Debug, Clone, Args)]
pub(crate) struct TuneOptions {
    /// The mode that is tuned.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) mode: barrelman_experiments::law_choice::ModeName,
    /// Tunings that are tried.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) rounds: u64,
    /// Trials of each condition for each tuning, with the seeds from 1 on.
    #[arg(long, value_name = "N", default_value_t = 24)]
    pub(crate) seeds: u64,
    /// Seed of the search.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(crate) search: u64,
    /// Change a value that the search begins with (repeatable); the names are those that it prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
}

impl Options {
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
