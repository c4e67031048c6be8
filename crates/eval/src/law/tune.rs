//! Searches for a tuning of the optimal law, on seeds that are not used for judging.
//!
//! A random walk: each round changes a few values of the best tuning so far, and keeps the change if the cost is lower.
//! The cost sums, over conditions and metrics, by how much a ratio exceeds its limit less a margin. Time outside and
//! energy count beyond that, with a small weight.

use anyhow::Result;
use barrelman_control::optimal::Tuning;
use barrelman_experiments::campaign::plan::CampaignPlan;
use barrelman_experiments::law_choice::ModeName;
use barrelman_sim::noise;
use barrelman_trial::campaign::compare::{METRICS, Metric};
use barrelman_trial::metrics::{TrialEntry, TrialMetrics};

use super::conditions::{CONDITIONS, Condition};
use super::law_under_test::LawUnderTest;
use super::options::TuneOptions;
use super::requirements::max_ratio;
use super::tuning_parameters::{PARAMETERS, to_options, with_changes};
use crate::output::print_line;

/// The first seed of the trials.
const FIRST_SEED: u64 = 1;
/// A ratio is to be at most this share of its limit.
const MARGIN: f64 = 0.93;
/// Weight of the logarithms of time outside and energy.
const LOG_WEIGHT: f64 = 0.01;
/// Added to both means of a ratio, so that rare events such as lost trials count less.
const RATIO_FLOOR: f64 = 0.02;
/// Widths of the random steps as shares of the ranges; mostly short ones, to escape a local minimum a long one.
const SHORT_STEP: f64 = 0.08;
const LONG_STEP: f64 = 0.3;
const LONG_STEP_PROBABILITY: f64 = 0.2;
/// How many values a round changes on average.
const MEAN_CHANGES: f64 = 2.5;

/// A condition with the motor schema's means.
struct Baseline {
    condition: &'static Condition,
    plan: CampaignPlan,
    /// In the order of [`METRICS`].
    means: Vec<Option<f64>>,
}

/// What is minimised.
struct Objective {
    /// The mode's name in the requirements.
    mode: &'static str,
    baselines: Vec<Baseline>,
    /// Trials of each condition.
    seeds: u64,
}

/// Searches, and prints each improvement.
pub(super) fn run(options: &TuneOptions) -> Result<()> {
    let (tuning, mode) = match options.mode {
        ModeName::MinimumEnergy => (Tuning::MINIMUM_ENERGY, "minimum-energy"),
        ModeName::TimeFuel => (Tuning::TIME_FUEL, "time-fuel"),
        ModeName::Eco => (Tuning::ECO, "eco"),
    };
    let objective = Objective::new(mode, options.seeds)?;
    let mut best = with_changes(tuning, &options.set)?;
    let mut min_cost = objective.cost(&best)?;
    print_line(&format!("{mode}: {min_cost:.5} to begin with"));
    for round in 0..options.rounds {
        let candidate = mutate(&best, |index| noise::unit(options.search, round, index));
        let cost = objective.cost(&candidate)?;
        if cost < min_cost {
            (best, min_cost) = (candidate, cost);
            print_line(&format!("round {round}: {min_cost:.5} {}", to_options(&best)));
        }
    }
    Ok(())
}

/// Changes a few values. `random` gives uniform deviates in [0, 1) by their index.
fn mutate(tuning: &Tuning, random: impl Fn(u64) -> f64) -> Tuning {
    let mut candidate = *tuning;
    let step = if random(0) < LONG_STEP_PROBABILITY { LONG_STEP } else { SHORT_STEP };
    for (index, (_, (low, high), field)) in (1_u64..).zip(&PARAMETERS) {
        if random(2 * index) < MEAN_CHANGES / PARAMETERS.len() as f64 {
            let value = field(&mut candidate);
            *value = (*value + step * (high - low) * (2.0 * random(2 * index + 1) - 1.0)).clamp(*low, *high);
        }
    }
    candidate
}

impl Objective {
    fn new(mode: &'static str, seeds: u64) -> Result<Self> {
        let baselines = CONDITIONS
            .iter()
            // A platform that stands still is nearly like one indoors; conditions without requirements only cost time.
            .filter(|condition| {
                let is_judged = |(metric, _, _): &Metric| max_ratio(condition, mode, metric).is_some();
                condition.setting != "still" && METRICS.iter().any(is_judged)
            })
            .map(|condition| {
                let plan = condition.plan()?;
                let means = means(&simulate(&plan, &LawUnderTest::MotorSchema, seeds)?);
                Ok(Baseline { condition, plan, means })
            })
            .collect::<Result<_>>()?;
        Ok(Self { mode, baselines, seeds })
    }

    fn cost(&self, tuning: &Tuning) -> Result<f64> {
        let mut cost = 0.0;
        for baseline in &self.baselines {
            let means = means(&simulate(&baseline.plan, &LawUnderTest::Optimal(*tuning), self.seeds)?);
            for (((metric, _, _), base), mean) in METRICS.iter().zip(&baseline.means).zip(means) {
                let (Some(base), Some(mean)) = (base, mean) else { continue };
                let required = max_ratio(baseline.condition, self.mode, metric);
                let limit = required.or_else(|| desired_ratio(baseline.condition, self.mode, metric));
                let Some(limit) = limit else { continue };
                let ratio = (mean + RATIO_FLOOR) / (base + RATIO_FLOOR);
                let excess = (ratio / (MARGIN * limit) - 1.0).max(0.0);
                cost += excess * excess + 0.1 * excess;
                if matches!(*metric, "time outside" | "integral of rate squared") {
                    cost += LOG_WEIGHT * (ratio / limit).max(1e-3).ln();
                }
            }
        }
        Ok(cost)
    }
}

/// A limit that is not required but desired: in the laboratory the minimum-energy mode is to rest the camera, too.
/// Elsewhere the schema hardly moves the camera, so that its time in motion is no reference.
fn desired_ratio(condition: &Condition, mode: &str, metric: &str) -> Option<f64> {
    let is_desired = mode == "minimum-energy" && metric == "movement time";
    (is_desired && condition.is_laboratory()).then_some(4.0)
}

fn simulate(plan: &CampaignPlan, law: &LawUnderTest, seeds: u64) -> Result<Vec<TrialEntry>> {
    law.simulate(plan, FIRST_SEED..FIRST_SEED + seeds)
}

/// The mean of each metric over the trials that have it.
fn means(trials: &[TrialEntry]) -> Vec<Option<f64>> {
    let mean = |value: &fn(&TrialMetrics) -> Option<f64>| {
        let values: Vec<f64> = trials.iter().filter_map(|trial| value(&trial.metrics)).collect();
        (!values.is_empty()).then(|| crate::statistics::mean(&values))
    };
    METRICS.iter().map(|(_, _, value)| mean(value)).collect()
}
