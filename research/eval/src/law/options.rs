//! Options of `barrelman-eval law`.

use barrelman_experiments::law_choice::named_values;
use barrelman_vocab::{Named as _, OptimalMode};
use clap::Args;

/// Options of `law`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Trials of each condition.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub(crate) seeds: u64,
    /// The first seed: no value of a law was chosen on seeds from 20,000 on.
    #[arg(long, value_name = "SEED", default_value_t = 20_000)]
    pub(crate) first_seed: u64,
    /// Only conditions whose name begins so, or `robustness` or `vehicles` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    /// Only laws whose name begins so, such as `minimum-energy` or `LQG` (repeatable).
    #[arg(long, value_name = "NAME")]
    pub(crate) law: Vec<String>,
    /// The mode of the tables `robustness` and `vehicles`.
    #[arg(long, value_parser = named_values::<OptimalMode>(), default_value = OptimalMode::default().key())]
    pub(crate) mode: OptimalMode,
}

impl Options {
    /// The seeds of the trials.
    pub(super) fn seeds(&self) -> std::ops::Range<u64> {
        self.first_seed..self.first_seed + self.seeds
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
