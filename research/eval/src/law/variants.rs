//! Tables of variants: the laboratory's trials in a changed world or with a changed profile, the motor schema
//! beside the optimal law in each.

use anyhow::Result;
use barrelman_experiments::campaign::plan::CampaignPlan;
use barrelman_sim::Scenario;
use barrelman_trial::campaign::compare::{CampaignComparison, PairedMetric};
use barrelman_trial::campaign::statistics::Bootstrap;
use barrelman_vocab::OptimalMode;
use barrelman_vocab::VehicleProfile;

use super::conditions::Condition;
use super::law_under_test::LawUnderTest;
use super::options::Options;
use crate::output::print_line;

/// The columns: the printed name, and the metric of a comparison.
const COLUMNS: [(&str, &str); 8] = [
    ("outside", "time outside"),
    ("rate2", "integral of rate squared"),
    ("moves", "moves"),
    ("|rate|", "integral of |rate|"),
    ("moving", "movement time"),
    ("variat.", "variation"),
    ("jerk", "jerk"),
    ("max P", "largest P"),
];

/// The largest ratio to the schema's mean that every column may have.
const MAX_RATIO: f64 = 1.0;
/// The same where the video drops out.
const MAX_RATIO_WITH_DROP_OUTS: f64 = 1.1;

/// The conditions that the variants change.
const CONDITIONS_OF_VARIANTS: [Condition; 2] =
    [Condition { scenario: "lab1", setting: "indoor" }, Condition { scenario: "lab2", setting: "indoor" }];

/// A change of the trials.
pub(super) struct Variant {
    pub(super) name: &'static str,
    /// Changes the simulated world, which the law does not know.
    pub(super) change_world: fn(&mut Scenario),
    /// Changes the profile from which the law computes.
    pub(super) change_profile: fn(&mut VehicleProfile),
    /// Whether the gimbal reports the camera's tilt.
    pub(super) reports_tilt: bool,
    /// The latency that the times of capture assume, seconds; `None`: the true times.
    pub(super) assumed_latency_s: Option<f64>,
}

impl Variant {
    pub(super) const fn new(
        name: &'static str,
        change_world: fn(&mut Scenario),
        change_profile: fn(&mut VehicleProfile),
    ) -> Self {
        Self { name, change_world, change_profile, reports_tilt: false, assumed_latency_s: None }
    }

    /// The trials of a plan with this variant's changes.
    fn changed(&self, plan: &CampaignPlan) -> CampaignPlan {
        plan.clone()
            .with_changed_scenario(self.change_world)
            .with_changed_profile(self.change_profile)
            .with_tilt_reports(self.reports_tilt)
    }

    /// The optimal law of this variant.
    fn law(&self, mode: OptimalMode) -> LawUnderTest {
        self.assumed_latency_s.map_or(LawUnderTest::Optimal(mode), |latency_s| {
            LawUnderTest::OptimalWithAssumedLatency(mode, latency_s)
        })
    }
}

/// Prints a table of variants. Returns whether the upper ends of all ratios are within the limit in every
/// row, and no more trials are lost than with the motor schema.
///
/// # Errors
/// If a scenario cannot be used.
pub(super) fn print_table(title: &str, variants: &[Variant], options: &Options) -> Result<bool> {
    let mut is_met = true;
    let seeds = options.seeds();
    for condition in CONDITIONS_OF_VARIANTS {
        let plan = condition.nominal_plan()?;
        let scenario = condition.scenario;
        print_line(&format!(
            "\n{scenario}, {title}: {} trials, seeds from {} on; the optimal law's ratios to the schema's means",
            options.seeds, options.first_seed
        ));
        let names: Vec<String> = COLUMNS.iter().map(|(name, _)| format!("{name:>7}")).collect();
        print_line(&format!(
            "  {:42} {}  lost (schema); upper ends of the 95 % intervals that exceed the limit",
            "",
            names.join(" ")
        ));
        for variant in variants {
            let plan = variant.changed(&plan);
            let baseline = LawUnderTest::MotorSchema.simulate(&plan, seeds.clone())?;
            let optimal = variant.law(options.mode).simulate(&plan, seeds.clone())?;
            let comparison = CampaignComparison::new(&baseline, &optimal, &Bootstrap::DEFAULT);
            let drops_out = plan.scenario().camera.video.impaired_share > 0.0;
            let limit = if drops_out { MAX_RATIO_WITH_DROP_OUTS } else { MAX_RATIO };
            is_met &= print_row(variant.name, &comparison, limit);
        }
    }
    Ok(is_met)
}

/// Prints a row. Returns whether its upper ends are within the limit and no more trials are lost.
fn print_row(name: &str, comparison: &CampaignComparison, limit: f64) -> bool {
    let paired = |metric: &str| comparison.metrics.iter().find(|paired| paired.metric == metric);
    let cells: Vec<String> =
        COLUMNS.iter().map(|(_, metric)| format!("{:>7}", ratio_cell(paired(metric)))).collect();
    let excesses: Vec<String> = COLUMNS
        .iter()
        .filter_map(|(name, metric)| {
            let high = paired(metric)?.ratio?.high;
            (high > limit).then(|| format!("{name} {high:.2}"))
        })
        .collect();
    let trials = comparison.pairs as f64;
    let [schema, optimal] = paired("lost")
        .map_or([0.0, 0.0], |paired| [paired.first * trials, paired.second * trials])
        .map(f64::round);
    print_line(&format!("  {name:42} {}  {optimal} ({schema})  {}", cells.join(" "), excesses.join(", ")));
    excesses.is_empty() && optimal <= schema
}

/// A ratio of means; empty where there is none.
fn ratio_cell(paired: Option<&PairedMetric>) -> String {
    paired.and_then(|paired| paired.ratio).map_or_else(String::new, |ratio| format!("{:.2}", ratio.value))
}

#[cfg(test)]
pub(super) fn assert_all_but_the_first_change_something(variants: &[Variant]) {
    let plan = CONDITIONS_OF_VARIANTS[0].nominal_plan().unwrap();
    for variant in &variants[1..] {
        let (mut world, mut profile) = (plan.scenario().clone(), plan.profile().clone());
        (variant.change_world)(&mut world);
        (variant.change_profile)(&mut profile);
        assert!(world != *plan.scenario() || profile != *plan.profile(), "{}", variant.name);
    }
}
