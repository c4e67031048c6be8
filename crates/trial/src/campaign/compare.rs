//! Paired comparison of two campaigns on the same seeds.
//!
//! Trials of the same name (`SCENARIO/SEED`) have the same target motion, sway and noise, so that differences
//! come from the settings of the campaigns. For each metric: both means, the ratio of the means, and the mean
//! difference, the last two with bootstrap intervals over the pairs. A trial may leave a metric undefined
//! (the sensitivity of a trial without a complete excursion): the paired figures rest on the pairs in which
//! both define it, and the mean over all trials that define it stands beside them.

use std::collections::BTreeMap;

use serde::Serialize;

use super::statistics::{Bootstrap, Interval};
use crate::metrics::{TrialEntry, TrialMetrics};

/// A metric that is compared: name, unit (empty: none), and the value of a trial, `None` where undefined.
pub type Metric = (&'static str, &'static str, fn(&TrialMetrics) -> Option<f64>);

/// The metrics that are compared.
pub const METRICS: [Metric; 28] = [
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
    ("success", "", |m| Some(f64::from(u8::from(m.is_success())))),
    ("tracked", "", |m| m.perception.tracked),
    ("longest time not tracked", "s", |m| m.perception.blind_s),
    ("sure and wrong", "", |m| m.perception.sure_wrong),
    ("first tracked after", "s", |m| m.perception.first_track_s),
    ("tracked again after", "s", |m| m.perception.reacquire_s),
    ("arrived", "", |m| m.guidance.map(|guidance| f64::from(u8::from(guidance.arrived)))),
    ("time to the circle", "s", |m| m.guidance?.time_to_circle_s),
    ("cross-track error", "m", |m| m.guidance?.cross_track_m),
    ("rudder travel", "", |m| m.guidance?.rudder_travel),
    ("closest approach to a person", "m", |m| m.guidance?.closest_person_m),
    ("path over straight way", "", |m| m.guidance?.path_ratio),
    ("boat and person in view", "", |m| m.guidance?.both_in_view),
];

/// One metric of both campaigns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairedMetric {
    /// Name of the metric.
    #[serde(rename = "figure")]
    pub metric: &'static str,
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// Number of pairs in which both trials define the metric.
    pub pairs: usize,
    /// Mean over the first campaign's trials of those pairs.
    pub first: f64,
    /// Mean over the second campaign's trials of those pairs.
    pub second: f64,
    /// Mean over all trials of the first campaign that define the metric: the figure that `metrics` gives for
    /// its file.
    pub first_of_all: MeanOfAll,
    /// The same of the second campaign.
    pub second_of_all: MeanOfAll,
    /// Mean of the second divided by the mean of the first; `None` where the latter is zero.
    pub ratio: Option<Interval>,
    /// Mean of the second minus the mean of the first.
    pub difference: Option<Interval>,
}

/// A mean over the trials of one campaign that define a metric.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanOfAll {
    /// Number of those trials.
    pub trials: usize,
    /// Their mean.
    pub mean: f64,
}

impl MeanOfAll {
    /// `None` of no values.
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (trials, sum) = values.fold((0_usize, 0.0), |(count, sum), value| (count + 1, sum + value));
        (trials > 0).then(|| Self { trials, mean: sum / trials as f64 })
    }
}

/// A metric that no pair defines.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnpairedMetric {
    /// Name of the metric.
    #[serde(rename = "figure")]
    pub metric: &'static str,
    /// Mean over the trials of the first campaign that define the metric; `None` where none does.
    pub first_of_all: Option<MeanOfAll>,
    /// The same of the second campaign.
    pub second_of_all: Option<MeanOfAll>,
}

/// The comparison of two campaigns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CampaignComparison {
    /// Number of trials present in both.
    pub pairs: usize,
    /// Names of the trials present in the first only.
    pub only_first: Vec<String>,
    /// Names of the trials present in the second only.
    pub only_second: Vec<String>,
    /// The metrics, in the order of [`METRICS`]; those that no pair defines are absent.
    #[serde(rename = "figures")]
    pub metrics: Vec<PairedMetric>,
    /// The metrics that some trials define, but no pair.
    #[serde(rename = "without_pairs")]
    pub unpaired: Vec<UnpairedMetric>,
}

impl CampaignComparison {
    /// Pairs two sets of trials by name and compares them.
    pub fn new(first: &[TrialEntry], second: &[TrialEntry], bootstrap: &Bootstrap) -> Self {
        let by_name = |trials: &'_ [TrialEntry]| -> BTreeMap<String, TrialMetrics> {
            trials.iter().map(|trial| (trial.name.clone(), trial.metrics.clone())).collect()
        };
        let (first, second) = (by_name(first), by_name(second));
        let pairs: Vec<(&TrialMetrics, &TrialMetrics)> =
            first.iter().filter_map(|(name, metrics)| Some((metrics, second.get(name)?))).collect();
        let missing = |from: &BTreeMap<String, TrialMetrics>, other: &BTreeMap<String, TrialMetrics>| {
            from.keys().filter(|name| !other.contains_key(*name)).cloned().collect()
        };
        let (mut metrics, mut unpaired) = (Vec::new(), Vec::new());
        for metric in METRICS {
            let of_all =
                |trials: &BTreeMap<String, TrialMetrics>| MeanOfAll::of(trials.values().filter_map(metric.2));
            let (first_of_all, second_of_all) = (of_all(&first), of_all(&second));
            let both = first_of_all.zip(second_of_all);
            match both.and_then(|of_all| compare_metric(metric, &pairs, of_all, bootstrap)) {
                Some(paired) => metrics.push(paired),
                None if first_of_all.is_none() && second_of_all.is_none() => {}
                None => unpaired.push(UnpairedMetric { metric: metric.0, first_of_all, second_of_all }),
            }
        }
        Self {
            pairs: pairs.len(),
            only_first: missing(&first, &second),
            only_second: missing(&second, &first),
            metrics,
            unpaired,
        }
    }
}

fn compare_metric(
    (metric, unit, value_of): Metric,
    pairs: &[(&TrialMetrics, &TrialMetrics)],
    (first_of_all, second_of_all): (MeanOfAll, MeanOfAll),
    bootstrap: &Bootstrap,
) -> Option<PairedMetric> {
    let values: Vec<(f64, f64)> =
        pairs.iter().filter_map(|(first, second)| value_of(first).zip(value_of(second))).collect();
    if values.is_empty() {
        return None;
    }
    let sums = |sample: &[usize]| {
        sample.iter().fold((0.0, 0.0), |sum, index| {
            let (first, second) = values[*index];
            (sum.0 + first, sum.1 + second)
        })
    };
    let all: Vec<usize> = (0..values.len()).collect();
    let (first, second) = sums(&all);
    let count = values.len() as f64;
    Some(PairedMetric {
        metric,
        unit,
        pairs: values.len(),
        first: first / count,
        second: second / count,
        first_of_all,
        second_of_all,
        ratio: bootstrap.interval(values.len(), |sample| {
            let (first, second) = sums(sample);
            second / first
        }),
        difference: bootstrap.interval(values.len(), |sample| {
            let (first, second) = sums(sample);
            (second - first) / count
        }),
    })
}
