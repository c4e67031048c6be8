//! Searches for a tuning of the optimal law, on seeds that are not used for judging.
//!
//! A random walk: each round changes a few values of the best tuning so far, and keeps the change if the cost is lower.
//! The cost sums, over conditions and metrics, by how much a ratio exceeds its limit less a margin. Time outside and
//! energy count beyond that, with a small weight.

use std::ops::Range;

use anyhow::Result;
use barrelman_control::optimal::ModeTuning;
use barrelman_experiments::campaign::plan::CampaignPlan;
use barrelman_sim::noise;
use barrelman_trial::campaign::compare::{METRICS, Metric};
use barrelman_trial::metrics::{TrialEntry, TrialMetrics};

use super::conditions::{CONDITIONS, Condition};
use super::law_under_test::LawUnderTest;
use super::options::TuneOptions;
use super::requirements::{max_achieved_ratio, max_ratio};
use super::tuning_parameters::{check_names, mutated, of_mode, to_options, with_changes};
use super::variants::{self, CONDITIONS_OF_VARIANTS, MAX_RATIO, Variant};
use super::{other_vehicles, profile_errors};
use crate::output::print_line;

/// A ratio is to be at most this share of its limit.
const MARGIN: f64 = 0.96;
/// Weight of the logarithms of time outside and energy.
const LOG_WEIGHT: f64 = 0.01;
/// Added to both means of a ratio, so that rare events such as lost trials count less.
const RATIO_FLOOR: f64 = 0.02;
/// The same for lost trials and for time out of the picture, which few seeds show.
const RARE_FLOOR: f64 = 0.5;
/// A candidate is given up when its cost exceeds the best by this: the terms still to come may be negative.
const INCOMPLETE_MARGIN: f64 = 0.1;
/// The time outside of variants is to be at most this share of the schema's, so that the search does not give up the boat
/// for what is saved of the movements.
const MAX_TIME_OUTSIDE_OF_VARIANTS: f64 = 0.5;
/// Widths of the random steps as shares of the ranges; mostly short ones, to escape a local minimum a long one.
const SHORT_STEP: f64 = 0.08;
const LONG_STEP: f64 = 0.3;
const LONG_STEP_PROBABILITY: f64 = 0.2;
/// How many values a round changes on average.
const MEAN_CHANGES: f64 = 2.5;

/// Means in the order of [`METRICS`].
type Means = Vec<Option<f64>>;

/// What trials are of: it gives the law, and the largest ratios to the motor schema's means.
#[derive(Clone, Copy)]
enum Subject {
    Condition(&'static Condition),
    Variant(&'static Variant),
}

/// Trials with the motor schema's means.
struct Baseline {
    subject: Subject,
    plan: CampaignPlan,
    /// Of the commands, and of the achieved motion.
    means: [Means; 2],
}

/// What is minimised.
struct Objective {
    /// The mode's name in the requirements.
    mode: &'static str,
    baselines: Vec<Baseline>,
    /// Trials of each condition.
    seeds: Range<u64>,
}

/// Searches, and prints each improvement.
pub(super) fn run(options: &TuneOptions) -> Result<()> {
    let (mode, tuning) = of_mode(options.mode);
    // Before the motor schema's trials, which take long.
    check_names(options.mode, &options.vary)?;
    let mut best = with_changes(tuning, &options.set)?;
    let objective = Objective::new(mode, options)?;
    let mut min_cost = objective.cost(best, f64::INFINITY)?;
    print_line(&format!("{mode}: {min_cost:.5} to begin with"));
    for round in 0..options.rounds {
        let random = |index| noise::unit(options.search, round, index);
        let step = if random(0) < LONG_STEP_PROBABILITY { LONG_STEP } else { SHORT_STEP };
        let candidate = mutated(best, &options.vary, step, MEAN_CHANGES, random);
        let cost = objective.cost(candidate, min_cost)?;
        if cost < min_cost {
            (best, min_cost) = (candidate, cost);
            print_line(&format!("round {round}: {min_cost:.5} {}", to_options(best)));
        }
    }
    Ok(())
}

impl Objective {
    fn new(mode: &'static str, options: &TuneOptions) -> Result<Self> {
        let seeds = options.first_seed..options.first_seed + options.seeds;
        let mut plans = Vec::new();
        for condition in CONDITIONS.iter().filter(|condition| is_chosen(condition, mode, &options.only)) {
            let plan = condition.plan()?.with_recorded_motion(seeds.clone())?;
            plans.push((Subject::Condition(condition), plan));
        }
        for condition in CONDITIONS_OF_VARIANTS {
            let plan = condition.nominal_plan()?.with_recorded_motion(seeds.clone())?;
            let variants = chosen_variants(&options.only);
            plans.extend(variants.map(|variant| (Subject::Variant(variant), variant.changed(&plan))));
        }
        anyhow::ensure!(
            !plans.is_empty(),
            "--only names no condition with requirements, no variant and no table of variants"
        );
        let baselines = plans
            .into_iter()
            .map(|(subject, plan)| {
                let means = means(&plan, &LawUnderTest::MotorSchema, &seeds)?;
                Ok(Baseline { subject, plan, means })
            })
            .collect::<Result<_>>()?;
        Ok(Self { mode, baselines, seeds })
    }

    /// The cost of a tuning; beyond `max_cost` the sum may be incomplete.
    fn cost(&self, tuning: ModeTuning, max_cost: f64) -> Result<f64> {
        let mut cost = 0.0;
        for baseline in &self.baselines {
            let means = means(&baseline.plan, &baseline.subject.law(tuning), &self.seeds)?;
            for (achieved, (base, mean)) in [false, true].into_iter().zip(baseline.means.iter().zip(means)) {
                cost += self.cost_of(baseline.subject, achieved, base, &mean);
            }
            if cost > max_cost + INCOMPLETE_MARGIN {
                break;
            }
        }
        Ok(cost)
    }

    fn cost_of(&self, subject: Subject, achieved: bool, base: &Means, means: &Means) -> f64 {
        let mut cost = 0.0;
        for (((metric, _, _), base), mean) in METRICS.iter().zip(base).zip(means) {
            let (Some(base), Some(mean)) = (base, mean) else { continue };
            let Some(limit) = subject.max_ratio(self.mode, metric, achieved) else { continue };
            let floor =
                if matches!(*metric, "lost" | "time out of the picture") { RARE_FLOOR } else { RATIO_FLOOR };
            let ratio = (mean + floor) / (base + floor);
            let excess = (ratio / (MARGIN * limit) - 1.0).max(0.0);
            cost += excess * excess + 0.1 * excess;
            if !achieved && matches!(*metric, "time outside" | "integral of rate squared") {
                cost += LOG_WEIGHT * (ratio / limit).max(1e-3).ln();
            }
        }
        cost
    }
}

impl Subject {
    fn law(self, tuning: ModeTuning) -> LawUnderTest {
        match self {
            Self::Condition(_) => LawUnderTest::Optimal(tuning),
            Self::Variant(variant) => variant.law(tuning),
        }
    }

    /// The largest ratio of a metric of the commands, or of the achieved motion.
    fn max_ratio(self, mode: &str, metric: &str, achieved: bool) -> Option<f64> {
        match self {
            Self::Condition(_) if achieved => max_achieved_ratio(mode, metric),
            Self::Condition(condition) => {
                max_ratio(condition, mode, metric).or_else(|| desired_ratio(condition, mode, metric))
            }
            Self::Variant(_) if achieved || !variants::is_judged(metric) => None,
            Self::Variant(_) if metric == "time outside" => Some(MAX_TIME_OUTSIDE_OF_VARIANTS),
            Self::Variant(_) => Some(MAX_RATIO),
        }
    }
}

/// Whether the search covers a condition.
fn is_chosen(condition: &Condition, mode: &str, only: &[String]) -> bool {
    // A platform that stands still is nearly like one indoors; conditions without requirements only cost time.
    let is_judged = |(metric, _, _): &Metric| max_ratio(condition, mode, metric).is_some();
    let is_still_laboratory = condition.setting == "still" && condition.is_laboratory();
    let is_named = only.is_empty() || only.iter().any(|prefix| condition.name().starts_with(prefix.as_str()));
    is_named && !is_still_laboratory && METRICS.iter().any(is_judged)
}

/// The variants that the search covers: those of a table that is named, and those whose name is given.
fn chosen_variants(only: &[String]) -> impl Iterator<Item = &'static Variant> {
    let is_named = move |name: &str| only.iter().any(|chosen| chosen == name);
    let tables = [
        ("vehicles", other_vehicles::VARIANTS.as_slice()),
        ("robustness", profile_errors::VARIANTS.as_slice()),
    ];
    tables.into_iter().flat_map(move |(table, variants)| {
        let all = is_named(table);
        variants.iter().filter(move |variant| all || is_named(variant.name))
    })
}

/// A limit that is not required but desired: in the laboratory the minimum-energy mode is to rest the camera, too.
/// Elsewhere the schema hardly moves the camera, so that its time in motion is no reference.
fn desired_ratio(condition: &Condition, mode: &str, metric: &str) -> Option<f64> {
    let is_desired = mode == "minimum-energy" && metric == "movement time";
    (is_desired && condition.is_laboratory()).then_some(4.0)
}

/// The mean of each metric over the trials that have it: of the commands, and of the achieved motion.
fn means(plan: &CampaignPlan, law: &LawUnderTest, seeds: &Range<u64>) -> Result<[Means; 2]> {
    let (commanded, achieved) = law.simulate_with_motion(plan, seeds.clone())?;
    Ok([commanded, achieved]
        .map(|trials| METRICS.iter().map(|(_, _, value)| mean_of(&trials, *value)).collect()))
}

fn mean_of(trials: &[TrialEntry], value: fn(&TrialMetrics) -> Option<f64>) -> Option<f64> {
    let values: Vec<f64> = trials.iter().filter_map(|trial| value(&trial.metrics)).collect();
    (!values.is_empty()).then(|| crate::statistics::mean(&values))
}
