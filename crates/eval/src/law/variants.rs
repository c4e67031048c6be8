//! Tables of variants: the laboratory's trials in a changed world or with a changed profile, the motor schema beside
//! the optimal law in each.

use anyhow::Result;
use barrelman_control::optimal::ModeTuning;
use barrelman_sim::Scenario;
use barrelman_trial::campaign::compare::{CampaignComparison, PairedMetric};
use barrelman_trial::campaign::statistics::Bootstrap;
use barrelman_vocab::VehicleProfile;

use super::comparison_table::ratio_cell;
use super::conditions::Condition;
use super::law_under_test::LawUnderTest;
use crate::output::print_line;

/// A change of the trials.
pub(super) struct Variant {
    pub(super) name: &'static str,
    /// Changes the simulated world, which the law does not know.
    pub(super) change_world: fn(&mut Scenario),
    /// Changes the profile from which the law computes.
    pub(super) change_profile: fn(&mut VehicleProfile),
    /// Whether the gimbal reports the camera's tilt.
    pub(super) reports_tilt: bool,
}

impl Variant {
    pub(super) const fn new(
        name: &'static str,
        change_world: fn(&mut Scenario),
        change_profile: fn(&mut VehicleProfile),
    ) -> Self {
        Self { name, change_world, change_profile, reports_tilt: false }
    }
}

/// Prints a table of variants. Returns whether the optimal law has less time outside and less energy than the motor
/// schema in every row.
///
/// # Errors
/// If a scenario cannot be used.
pub(super) fn print_table(
    title: &str,
    variants: &[Variant],
    (first_seed, seeds): (u64, u64),
    tuning: ModeTuning,
) -> Result<bool> {
    let mut is_met = true;
    for scenario in ["lab1", "lab2"] {
        print_line(&format!(
            "\n{scenario}, {title}: {seeds} trials, seeds from {first_seed} on; the optimal law's ratios to the \
             schema's means, 95 %"
        ));
        for variant in variants {
            let plan = Condition { scenario, setting: "indoor" }
                .nominal_plan()?
                .with_changed_scenario(variant.change_world)
                .with_changed_profile(variant.change_profile)
                .with_tilt_reports(variant.reports_tilt);
            let seeds = first_seed..first_seed + seeds;
            let baseline = LawUnderTest::MotorSchema.simulate(&plan, seeds.clone())?;
            let optimal = LawUnderTest::Optimal(tuning).simulate(&plan, seeds)?;
            let comparison = CampaignComparison::new(&baseline, &optimal, &Bootstrap::DEFAULT);
            is_met &= print_row(variant.name, &comparison);
        }
    }
    Ok(is_met)
}

/// Prints a row. Returns whether the optimal law has less time outside and less energy.
fn print_row(name: &str, comparison: &CampaignComparison) -> bool {
    let metric = |metric| comparison.metrics.iter().find(|paired| paired.metric == metric);
    let (outside, energy, moves) =
        (metric("time outside"), metric("integral of rate squared"), metric("moves"));
    let is_better = [outside, energy].iter().all(|paired| paired.is_some_and(|p| p.second < p.first));
    let cell = |paired: Option<&PairedMetric>| {
        paired.map_or_else(String::new, |p| format!("{:7.3} {}", p.first, ratio_cell(p.ratio)))
    };
    print_line(&format!(
        "  {name:34} outside {}  rate2 {}  moves {}  {}",
        cell(outside),
        cell(energy),
        cell(moves),
        if is_better { "" } else { "WORSE" }
    ));
    is_better
}

#[cfg(test)]
pub(super) fn assert_all_but_the_first_change_something(variants: &[Variant]) {
    let plan = Condition { scenario: "lab1", setting: "indoor" }.nominal_plan().unwrap();
    for variant in &variants[1..] {
        let (mut world, mut profile) = (plan.scenario().clone(), plan.profile().clone());
        (variant.change_world)(&mut world);
        (variant.change_profile)(&mut profile);
        assert!(world != *plan.scenario() || profile != *plan.profile(), "{}", variant.name);
    }
}
