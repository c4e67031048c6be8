//! Compares the camera laws on the same seeds, and judges the optimal law.
//!
//! Trials are simulated with truth as perception, in the conditions of [`conditions`]. Judged are the ratios
//! of the optimal law's mean metrics to the motor schema's: the upper end of the 95 % interval must meet the
//! limit in [`requirements`]. In the tables of [`profile_errors`] and [`other_vehicles`] every ratio must be
//! at most 1 in every row, at most 1.1 where the video drops out. An LQG and an MPC law are references only
//! and not part of the product.

mod clairvoyant;
mod comparison_table;

mod other_vehicles;
mod profile_errors;
mod variants;

pub(crate) mod conditions;
mod requirements;

mod achieved_motion;
mod assumed_latency;
mod law_under_test;
mod lqg;
mod mpc;
mod target_predictor;

mod options;

pub(crate) use options::Options;

use anyhow::Result;

use conditions::{CONDITIONS, Condition};

/// Prints the chosen tables. Returns whether every requirement holds.
///
/// # Errors
/// If a scenario cannot be used.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let chosen: Vec<&Condition> =
        CONDITIONS.iter().filter(|condition| options.includes_condition(&condition.name())).collect();
    let mut is_met = comparison_table::print(&chosen, options)?;
    if options.includes_table("robustness") {
        is_met &= profile_errors::print(options)?;
    }
    if options.includes_table("vehicles") {
        is_met &= other_vehicles::print(options)?;
    }
    Ok(is_met)
}
