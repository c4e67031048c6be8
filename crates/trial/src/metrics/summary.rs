//! PooledMetrics metrics of several trials, by arena.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::mean::mean;
use super::trial::TrialMetrics;

/// The published normalised sensitivity of both arenas, 1/s.
pub const PUBLISHED_NORMALISED_SENSITIVITY: &str = "0.034";

/// An arena of the paper: 1 or 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Arena(u8);

impl Arena {
    /// Arena 1 or 2; `None` for any other number.
    pub fn from_number(number: u8) -> Option<Self> {
        (1..=2).contains(&number).then_some(Self(number))
    }

    /// The arena in a file name like `arena1_07.csv`; `None` without one.
    pub fn from_name(name: &str) -> Option<Self> {
        let (_, rest) = name.split_once("arena")?;
        let digits = rest.find(|next: char| !next.is_ascii_digit()).unwrap_or(rest.len());
        Self::from_number(rest[..digits].parse().ok()?)
    }

    /// The arena's number.
    pub const fn number(self) -> u8 {
        self.0
    }

    /// The published divisor n of the normalised sensitivity: 18 and 13.
    pub const fn published_n(self) -> f64 {
        if self.0 == 1 { 18.0 } else { 13.0 }
    }

    /// The published mean sensitivity, 1/s.
    pub const fn published_sensitivity(self) -> f64 {
        if self.0 == 1 { 0.6045 } else { 0.4536 }
    }
}

/// One trial in a summary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialEntry {
    /// Name: the file's, or `SCENARIO/SEED`.
    pub name: String,
    /// The arena, if it is one of the paper's.
    pub arena: Option<Arena>,
    /// The metrics.
    #[serde(flatten)]
    pub metrics: TrialMetrics,
}

/// Metrics pooled over several trials.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PooledMetrics {
    /// Mean of the trials' sensitivities, 1/s.
    pub mean_sensitivity: Option<f64>,
    /// The mean sensitivity divided by the arena's published n; outside the paper's arenas by the mean number
    /// of excursions.
    pub normalised_sensitivity: Option<f64>,
    /// Share of successful trials, 0 to 1.
    pub success_rate: Option<f64>,
}

/// The summary of one arena.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArenaSummary {
    /// The pooled metrics.
    #[serde(flatten)]
    pub pooled: PooledMetrics,
    /// Number of trials.
    pub trials: usize,
}

/// The document that `metrics --json` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Every trial.
    pub trials: Vec<TrialEntry>,
    /// The paper's arenas, by number.
    pub arenas: BTreeMap<String, ArenaSummary>,
    /// PooledMetrics over all trials; all null where the trials come from several arenas.
    #[serde(flatten)]
    pub pooled: PooledMetrics,
}

/// Summarises trials, by arena and together.
pub fn summarise(trials: Vec<TrialEntry>) -> Summary {
    let mut by_arena: BTreeMap<Option<Arena>, Vec<&TrialMetrics>> = BTreeMap::new();
    for trial in &trials {
        by_arena.entry(trial.arena).or_default().push(&trial.metrics);
    }
    let arenas = by_arena
        .iter()
        .filter_map(|(arena, metrics)| {
            let arena = (*arena)?;
            let figures = ArenaSummary { pooled: pool(metrics, Some(arena)), trials: metrics.len() };
            Some((arena.number().to_string(), figures))
        })
        .collect();
    let pooled = match by_arena.iter().next() {
        Some((arena, metrics)) if by_arena.len() == 1 => pool(metrics, *arena),
        _ => PooledMetrics { mean_sensitivity: None, normalised_sensitivity: None, success_rate: None },
    };
    Summary { trials, arenas, pooled }
}

fn pool(trials: &[&TrialMetrics], arena: Option<Arena>) -> PooledMetrics {
    let mean_sensitivity = mean(trials.iter().filter_map(|trial| trial.sensitivity));
    let n = arena
        .map(Arena::published_n)
        .or_else(|| mean(trials.iter().map(|trial| trial.excursions as f64)))
        .filter(|n| *n > 0.0);
    let succeeded = trials.iter().filter(|trial| trial.is_success()).count();
    PooledMetrics {
        mean_sensitivity,
        normalised_sensitivity: mean_sensitivity.zip(n).map(|(mean, n)| mean / n),
        success_rate: (!trials.is_empty()).then(|| succeeded as f64 / trials.len() as f64),
    }
}
