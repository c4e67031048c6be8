//! The table of laws and conditions: each law's metrics beside the motor schema's, with the limits that are
//! judged.

use anyhow::Result;
use barrelman_trial::campaign::compare::{CampaignComparison, PairedMetric};
use barrelman_trial::campaign::statistics::{Bootstrap, Interval};
use barrelman_vocab::{Named as _, OptimalMode};

use super::clairvoyant;
use super::conditions::Condition;
use super::law_under_test::LawUnderTest;
use super::options::Options;
use super::requirements::{max_achieved_ratio, max_ratio};
use crate::output::print_line;

/// The rows of a law: the printed name, and the metric of a comparison.
const METRICS: [(&str, &str); 11] = [
    ("outside", "time outside"),
    ("rate2", "integral of rate squared"),
    ("moves", "moves"),
    ("|rate|", "integral of |rate|"),
    ("moving", "movement time"),
    ("variat.", "variation"),
    ("jerk", "jerk"),
    ("s", "sensitivity"),
    ("max P", "largest P"),
    ("out pic", "time out of the picture"),
    ("lost", "lost"),
];

/// The rows of a law's achieved motion.
const ACHIEVED_METRICS: [(&str, &str); 5] = [
    ("rate2", "integral of rate squared"),
    ("moves", "moves"),
    ("|rate|", "integral of |rate|"),
    ("moving", "movement time"),
    ("variat.", "variation"),
];

/// Most trials of each condition for a law that solves an optimisation problem for each picture.
const MAX_SEEDS_OF_SLOW_LAW: u64 = 48;

/// Most trials of each condition in which the path is taken as known.
const MAX_SEEDS_OF_CLAIRVOYANT: u64 = 48;

/// All laws that are compared with the schema, with their names.
fn laws() -> [(&'static str, LawUnderTest); 8] {
    [
        optimal(OptimalMode::MinimumEnergy),
        optimal(OptimalMode::TimeFuel),
        optimal(OptimalMode::Eco),
        optimal(OptimalMode::Intermittent),
        ("centre", LawUnderTest::Centring),
        ("LQG, weight 1", LawUnderTest::Lqg(1.0)),
        ("LQG, weight 10", LawUnderTest::Lqg(10.0)),
        ("MPC", LawUnderTest::Mpc),
    ]
}

fn optimal(mode: OptimalMode) -> (&'static str, LawUnderTest) {
    (mode.key(), LawUnderTest::Optimal(mode))
}

/// Prints the table. Returns whether every requirement holds.
pub(super) fn print(conditions: &[&Condition], options: &Options) -> Result<bool> {
    let Options { first_seed, seeds, .. } = *options;
    let mut is_met = true;
    for condition in conditions {
        let plan = condition.plan()?;
        let baseline = LawUnderTest::MotorSchema.simulate_with_motion(&plan, options.seeds())?;
        print_line(&format!(
            "\n{}: {seeds} trials, seeds from {first_seed} on; ratios to the schema's means, 95 %",
            condition.name()
        ));
        let enough =
            clairvoyant::mean_travel(&plan, first_seed..first_seed + seeds.min(MAX_SEEDS_OF_CLAIRVOYANT))?;
        print_line(&format!(
            "  with the target's path known, {enough:.2} rad of travel are enough to keep it inside"
        ));
        for (name, law) in laws().iter().filter(|(name, _)| options.includes_law(name)) {
            let count = if law.is_slow() { seeds.min(MAX_SEEDS_OF_SLOW_LAW) } else { seeds };
            let trials = law.simulate_with_motion(&plan, first_seed..first_seed + count)?;
            let comparison = CampaignComparison::new(&baseline.0, &trials.0, &Bootstrap::DEFAULT);
            is_met &=
                print_rows(name, "", &comparison, &METRICS, |metric| max_ratio(condition, name, metric));
            let comparison = CampaignComparison::new(&baseline.1, &trials.1, &Bootstrap::DEFAULT);
            is_met &= print_rows(name, "achieved ", &comparison, &ACHIEVED_METRICS, |metric| {
                max_achieved_ratio(name, metric)
            });
        }
    }
    Ok(is_met)
}

/// Prints rows of a law. Returns whether its requirements hold.
fn print_rows(
    law: &str,
    prefix: &str,
    comparison: &CampaignComparison,
    metrics: &[(&str, &str)],
    limit: impl Fn(&str) -> Option<f64>,
) -> bool {
    let mut is_met = true;
    for (printed_name, metric) in metrics {
        let Some(paired) = comparison.metrics.iter().find(|paired| paired.metric == *metric) else {
            continue;
        };
        let limit = limit(metric);
        let is_missed = limit.is_some_and(|limit| !is_within(paired, limit));
        is_met &= !is_missed;
        print_line(&format!(
            "  {law:15} {:17} {:>9.3} {:>9.3}  {}  {}",
            format!("{prefix}{printed_name}"),
            paired.first,
            paired.second,
            ratio_cell(paired.ratio),
            match (limit, is_missed) {
                (None, _) => String::new(),
                (Some(limit), false) => format!("<= {limit}"),
                (Some(limit), true) => format!("<= {limit} MISSED"),
            }
        ));
    }
    is_met
}

/// A ratio with its interval, as a cell; empty where there is no ratio.
fn ratio_cell(ratio: Option<Interval>) -> String {
    ratio.map_or_else(String::new, |r| format!("{:.3} [{:.3}, {:.3}]", r.value, r.low, r.high))
}

/// Whether the upper end of a ratio's interval is within a limit. Where the schema's mean is 0, the law's
/// must be, too.
fn is_within(paired: &PairedMetric, limit: f64) -> bool {
    match paired.ratio {
        Some(ratio) => ratio.high <= limit,
        None => paired.second <= 0.0,
    }
}
