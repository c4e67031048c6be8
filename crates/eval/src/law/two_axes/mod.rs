//! How near a law comes to the optimum under its own model in both axes: a bound by rollouts.
//!
//! As in [`super::one_axis`], but the target moves in azimuth and elevation ([`target`]) and both axes of the camera follow, alike;
//! the region is the ellipse. The optimum in both axes is out of reach of a grid. [`rollout`] is a policy with a long
//! horizon: its cost is one that can be reached with exact knowledge of bearing and rates, so that the least cost is at most
//! that. The same policy with the target's path known beforehand shows what a better prediction would be worth; it is no
//! bound of the least cost in either direction.
//!
//! Not handled: sway, errors of the tracker, a target that returns to a mean direction.

mod plans;
mod rollout;
mod search;

mod policy;
mod world;

mod target;

use self::policy::BasePolicy;
use self::rollout::{Foresight, RolloutPolicy};
use self::target::TargetPath;
use self::world::{profile, simulate_law, simulate_policy};
use super::law_under_test::LawUnderTest;
use super::model_figures::{Figures, Prices, TRIAL_S, table_head};
use crate::output::print_line;
use crate::rng::Rng;

/// Most trials of each law.
const MAX_TRIALS: u64 = 24;
/// The laws that are printed beside the policies.
const LAWS: [&str; 3] = ["intermittent", "eco", "time-fuel"];

/// Prints the costs of laws beside those of the policies.
pub(super) fn print(first_seed: u64, trials: u64, laws: &[(&str, LawUnderTest)]) {
    let trials = trials.min(MAX_TRIALS);
    let seeds = || first_seed..first_seed + trials;
    let of_law = |law: &LawUnderTest| {
        Figures::mean_of_trials(seeds(), |seed| {
            simulate_law(law.build(&profile()), &TargetPath::of_seed(seed))
        })
    };
    let schema = of_law(&LawUnderTest::MotorSchema);
    let prices = Prices::of_ratios(&schema);
    let print_row = |name: &str, figures: &Figures| print_line(&figures.to_row(name, &schema, &prices));
    print_line(&format!(
        "\ntwo axes: {trials} trials of {TRIAL_S:.0} s, seeds from {first_seed} on; ratios to the schema, and the mean of ratio over limit"
    ));
    print_line(&table_head());
    print_row("motor schema", &schema);
    for (name, law) in laws.iter().filter(|(name, _)| LAWS.contains(name)) {
        print_row(name, &of_law(law));
    }
    let values = search::best_values(&prices);
    print_row("base policy, searched", &search::figures_of(values, seeds()));
    let base = BasePolicy::new(values);
    let rollouts = Figures::mean_of_trials(seeds(), |seed| {
        let foresight = Foresight::Model(Rng::from_name("futures of two axes", seed));
        simulate_policy(&mut RolloutPolicy::new(base, prices, foresight), &TargetPath::of_seed(seed))
    });
    print_row("rollouts of the base policy", &rollouts);
    let known = Figures::mean_of_trials(seeds(), |seed| {
        let path = TargetPath::of_seed(seed);
        simulate_policy(&mut RolloutPolicy::new(base, prices, Foresight::Path(&path)), &path)
    });
    print_row("the same, with the path known", &known);
    print_line(&format!("  the base policy: {values:.3?}"));
}
