//! Options of `barrelman-eval simulator` and `barrelman-eval fit`.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};

use crate::workspace::path_or_default;

/// Options of `simulator`.
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
    /// The first seed: nothing was tuned on seeds from 10,000 on.
    #[arg(long, value_name = "SEED", default_value_t = 10_000)]
    pub(crate) first_seed: u64,
}

/// A table of `simulator`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableName {
    /// Whether simulated trials resemble the recorded ones: the table that is judged.
    #[value(name = "believable")]
    Validation,
    /// The noise of the tracked position.
    #[value(name = "noise")]
    LocalisationNoise,
    /// The target's speed by its distance.
    #[value(name = "distance")]
    SpeedByDistance,
    /// Whether the target stays in the picture.
    #[value(name = "picture")]
    OutOfPicture,
    /// The published sensitivities, and the jumps of the authors' tracker.
    #[value(name = "jumps")]
    TrackerSpikes,
    /// The effect of the schema's rate.
    #[value(name = "rate")]
    MotorSchemaRate,
    /// The schema against centring.
    #[value(name = "centre")]
    Centring,
    /// The speed of the boat up to which the laws do not lose it.
    #[value(name = "speed")]
    BoatSpeed,
    /// How much faster than real time trials run.
    #[value(name = "pace")]
    RealTimeFactor,
}

/// Options of `fit`.
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
    /// Searches: the first starts from the scenario's values, the others from random ones.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(crate) starts: u64,
    /// Generations of each search, of 16 candidates.
    #[arg(long, value_name = "N", default_value_t = 60)]
    pub(crate) generations: u64,
    /// Simulated trials for each candidate, with seeds below 10,000.
    #[arg(long, value_name = "N", default_value_t = 96, value_parser = clap::value_parser!(u64).range(2..1_000))]
    pub(crate) seeds: u64,
    /// Candidates that are simulated at the same time.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(crate) threads: usize,
}

impl Options {
    /// The seeds of the simulated trials.
    pub(super) const fn seed_range(&self) -> Range<u64> {
        self.first_seed..self.first_seed + self.seeds
    }

    /// Whether a table is to be printed.
    pub(super) fn includes(&self, table: TableName) -> bool {
        self.only.is_none_or(|only| only == table)
    }

    pub(super) fn trials_folder(&self) -> Result<PathBuf> {
        path_or_default(self.trials.as_ref(), TRIALS_FOLDER)
    }
}

impl FitOptions {
    pub(super) fn trials_folder(&self) -> Result<PathBuf> {
        path_or_default(self.trials.as_ref(), TRIALS_FOLDER)
    }
}

/// The folder of recorded trials, from the workspace.
const TRIALS_FOLDER: &str = "../shared/data/trials";
