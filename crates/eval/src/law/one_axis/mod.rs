//! How near a law comes to the optimum under its own model: one axis, solved by dynamic programming.
//!
//! A target moves along the middle of the picture, so that only pan matters. Its bearing's rate is an
//! Ornstein-Uhlenbeck process; the axis answers after a dead time with a first-order lag ([`super::axis_model`]). The cost of a
//! second adds up time outside of the region, rate², starts, |rate|, time in motion and variation, each as a ratio to the
//! motor schema's mean under the same model and divided by the largest ratio that is wanted
//! ([`super::requirements`]). The schema's own cost is therefore above 1, and a law that just meets every limit costs 1.
//!
//! [`all_limits`] shows that no policy meets every limit under this model.
//!
//! [`dynamic_programming`] finds the policy with the least mean cost. It knows the target's bearing and its rate exactly
//! and decides ten times a second; the laws see the target's place in thirty pictures a second.
//!
//! Not handled: the second axis, sway, errors of the tracker, a target that returns to a mean direction.

mod all_limits;
mod dynamic_programming;
mod world;

mod tuned;

use barrelman_control::Law;

use self::dynamic_programming::DynamicProgramme;
use self::world::{simulate_law, simulate_policy};
use super::axis_model::edge;
use super::law_under_test::LawUnderTest;
use super::model_figures::{Figures, Prices, TRIAL_S, table_head};
use crate::output::print_line;

/// Trials of each law.
const TRIALS: u64 = 48;
/// Bearing rates for which the policy's thresholds are printed, rad/s away from the middle.
const RATES: [f64; 5] = [-0.1, 0.0, 0.1, 0.2, 0.3];

/// Prints the costs of laws beside the least one, and where the best policy starts and stops.
pub(super) fn print(first_seed: u64, laws: &[(&str, LawUnderTest)]) {
    let seeds = || first_seed..first_seed + TRIALS;
    let schema = Figures::mean_of_trials(seeds(), |seed| simulate_law(law(&LawUnderTest::MotorSchema), seed));
    let prices = Prices::of_ratios(&schema);
    print_line(&format!(
        "\none axis: {TRIALS} trials of {:.0} s, seeds from {first_seed} on; ratios to the schema, and the mean of ratio over limit",
        TRIAL_S
    ));
    print_line(&table_head());
    print_line(&schema.to_row("motor schema", &schema, &prices));
    let for_one_axis = ("intermittent, for one axis", LawUnderTest::Optimal(tuned::INTERMITTENT.into()));
    for (name, under_test) in laws.iter().chain([&for_one_axis]) {
        let figures = Figures::mean_of_trials(seeds(), |seed| simulate_law(law(under_test), seed));
        print_line(&figures.to_row(name, &schema, &prices));
    }
    let programme = DynamicProgramme::solve(&prices);
    let optimum = Figures::mean_of_trials(seeds(), |seed| simulate_policy(&programme, seed));
    print_line(&optimum.to_row("dynamic programming", &schema, &prices));
    print_line(&format!("  the programme expects a cost of {:.3} of its own policy", programme.mean_cost()));
    print_line("  it starts beyond, and at 0.28 rad/s stops below, shares of the way to the edge:");
    for rate in RATES {
        let [start, stop] = [0.0, 0.28].map(|in_force| {
            let moves = |offset: &f64| programme.decide(*offset, rate, in_force, in_force) > 0.0;
            let first = (-150..250).map(|k| 0.01 * f64::from(k) * edge()).find(moves);
            first.map_or_else(|| "never".to_owned(), |offset| format!("{:.2}", offset / edge()))
        });
        print_line(&format!("    bearing rate {rate:4.1} rad/s: {start}, {stop}"));
    }
    all_limits::print(&schema, seeds());
}

fn law(law: &LawUnderTest) -> Box<dyn Law> {
    law.build(&world::profile())
}
