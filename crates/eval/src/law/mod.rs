//! Compares the camera laws on the same seeds, judges the optimal law, and searches for its tuning.
//!
//! Trials are simulated with truth as perception, in the conditions of [`conditions`]. Judged are the ratios of the
//! optimal law's mean metrics to the motor schema's: the upper end of the 95 % interval must meet the limit in
//! [`requirements`]. [`horizon_curve`] draws time outside against movement, and [`one_axis`] shows how near the laws come to
//! the optimum of one axis,
//! [`two_axes`] how much better a policy of rollouts is in both. In the tables of [`profile_errors`] and [`other_vehicles`] every ratio must be at
//! most 1 in every row, at most 1.1 where the video drops out. An LQG and an MPC law are references only and not part of the product.

mod clairvoyant;
mod comparison_table;
mod horizon_curve;
mod one_axis;
mod two_axes;

mod other_vehicles;
mod profile_errors;
mod variants;

mod tune;

mod conditions;
mod requirements;
mod tuning_parameters;

mod axis_model;
mod model_figures;

mod achieved_motion;
mod assumed_latency;
mod law_under_test;
mod lqg;
mod mpc;
mod target_predictor;

mod options;

pub(crate) use options::{Options, TuneOptions};

use anyhow::Result;

use conditions::{CONDITIONS, Condition};

/// Prints the chosen tables. Returns whether every requirement holds.
///
/// # Errors
/// If a scenario cannot be used, or a changed value does not exist.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let chosen: Vec<&Condition> =
        CONDITIONS.iter().filter(|condition| options.includes_condition(&condition.name())).collect();
    if options.curve {
        return horizon_curve::print(&chosen, options, &comparison_table::laws(options)?);
    }
    let tuning = options.tuning()?;
    let mut is_met = comparison_table::print(&chosen, options)?;
    if options.includes_table("robustness") {
        is_met &= profile_errors::print(options.first_seed, options.seeds, tuning)?;
    }
    if options.includes_table("vehicles") {
        is_met &= other_vehicles::print(options.first_seed, options.seeds, tuning)?;
    }
    if options.includes_table("one-axis") {
        one_axis::print(options.first_seed, &comparison_table::laws(options)?);
    }
    if options.includes_table("two-axes") {
        two_axes::print(options.first_seed, options.seeds, &comparison_table::laws(options)?);
    }
    Ok(is_met)
}

/// Searches for a tuning and prints what it finds.
///
/// # Errors
/// If a scenario cannot be used, or a changed value does not exist.
pub(crate) fn tune(options: &TuneOptions) -> Result<()> {
    tune::run(options)
}
