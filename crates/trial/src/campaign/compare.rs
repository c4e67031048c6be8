//! Two campaigns on the same seeds, paired.
//!
//! Trials of one name (`SCENARIO/SEED`) met the same target, the same sway and the same noise, so that what
//! differs is what the campaigns differ in. For each figure: both means, the ratio of the means, and the mean
//! difference, the last two with intervals from resampling pairs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::statistics::{Bootstrap, Interval};
use crate::metrics::{TrialEntry, TrialMetrics};

/// A figure: its name, its unit, and where a trial has it.
pub type Figure = (&'static str, &'static str, fn(&TrialMetrics) -> Option<f64>);

/// The figures that are compared: name, unit, and where a trial has it.
pub const FIGURES: [Figure; 15] = [
    ("time outside", "s", |m| Some(m.time_outside_s)),
    ("excursions", "", |m| Some(m.excursions as f64)),
    ("largest P", "", |m| m.max_p),
    ("mean h", "", |m| m.mean_h),
    ("mean b", "s", |m| m.mean_b_s),
    ("sensitivity", "1/s", |m| m.sensitivity),
    ("integral of |rate|", "rad", |m| m.travel_rad),
    ("integral of rate squared", "rad2/s", |m| m.effort_rad2_per_s),
    ("moves", "", |m| m.moves.map(|moves| moves as f64)),
    ("switches", "", |m| m.switches.map(|switches| switches as f64)),
    ("movement time", "s", |m| m.movement_s),
    ("variation", "rad/s", |m| m.variation_rad_per_s),
    ("jerk", "rad/s3", |m| m.jerk_rad_per_s3),
    ("time out of the picture", "s", |m| m.out_of_picture_s),
    ("lost", "", |m| m.lost.map(|lost| f64::from(u8::from(lost)))),
];

/// One figure of both campaigns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Paired {
    /// Its name.
    pub figure: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// Pairs in which both trials have it.
    pub pairs: usize,
    /// Mean of the first campaign.
    pub first: f64,
    /// Mean of the second.
    pub second: f64,
    /// Mean of the second divided by that of the first; `None` where that is zero.
    pub ratio: Option<Interval>,
    /// Mean of the second less that of the first.
    pub difference: Option<Interval>,
}

/// Two campaigns compared.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Trials in both.
    pub pairs: usize,
    /// Names in the first only.
    pub only_first: Vec<String>,
    /// Names in the second only.
    pub only_second: Vec<String>,
    /// The figures.
    pub figures: Vec<Paired>,
}

impl Comparison {
    /// Pairs two sets of trials by name.
    pub fn of(first: &[TrialEntry], second: &[TrialEntry], bootstrap: &Bootstrap) -> Self {
        let by_name = |trials: &'_ [TrialEntry]| -> BTreeMap<String, TrialMetrics> {
            trials.iter().map(|trial| (trial.name.clone(), trial.metrics.clone())).collect()
        };
        let (first, second) = (by_name(first), by_name(second));
        let pairs: Vec<(&TrialMetrics, &TrialMetrics)> =
            first.iter().filter_map(|(name, metrics)| Some((metrics, second.get(name)?))).collect();
        let missing = |from: &BTreeMap<String, TrialMetrics>, other: &BTreeMap<String, TrialMetrics>| {
            from.keys().filter(|name| !other.contains_key(*name)).cloned().collect()
        };
        let figures = FIGURES
            .iter()
            .filter_map(|(figure, unit, of)| paired(figure, unit, &pairs, *of, bootstrap))
            .collect();
        Self {
            pairs: pairs.len(),
            only_first: missing(&first, &second),
            only_second: missing(&second, &first),
            figures,
        }
    }
}

fn paired(
    figure: &'static str,
    unit: &'static str,
    pairs: &[(&TrialMetrics, &TrialMetrics)],
    of: fn(&TrialMetrics) -> Option<f64>,
    bootstrap: &Bootstrap,
) -> Option<Paired> {
    let values: Vec<(f64, f64)> =
        pairs.iter().filter_map(|(first, second)| of(first).zip(of(second))).collect();
    if values.is_empty() {
        return None;
    }
    let sums = |taken: &[usize]| {
        taken.iter().fold((0.0, 0.0), |sum, index| {
            let (first, second) = values[*index];
            (sum.0 + first, sum.1 + second)
        })
    };
    let all: Vec<usize> = (0..values.len()).collect();
    let (first, second) = sums(&all);
    let count = values.len() as f64;
    Some(Paired {
        figure,
        unit,
        pairs: values.len(),
        first: first / count,
        second: second / count,
        ratio: bootstrap.interval(values.len(), |taken| {
            let (first, second) = sums(taken);
            second / first
        }),
        difference: bootstrap.interval(values.len(), |taken| {
            let (first, second) = sums(taken);
            (second - first) / count
        }),
    })
}
