//! Whether any policy can meet all limits at once.
//!
//! For weights that add up to 1, let the cost be the sum of weight times ratio over limit. A policy that meets every limit
//! costs at most 1 with any weights. Where even the least cost is above 1, no policy meets them all, nor does one that
//! takes turns with others: its worst ratio over limit is at least the least cost.

use super::super::model_figures::{Figures, Prices};
use super::dynamic_programming::DynamicProgramme;
use super::world::simulate_policy;
use crate::output::print_line;

/// The weights, in the order of the figures, whose least cost is the largest that was found (40 multiplicative updates: a figure
/// gets more weight the further the policy of the last weights exceeds its limit). Any weights prove as much as their least cost says.
const WEIGHTS: [f64; 6] = [0.111, 0.305, 0.081, 0.138, 0.299, 0.066];

/// Prints the least cost with these weights, and the figures of its policy.
pub(super) fn print(schema: &Figures, seeds: core::ops::Range<u64>) {
    let prices = Prices::of_weighted_ratios(schema, WEIGHTS);
    let programme = DynamicProgramme::solve(&prices);
    let figures = Figures::mean_of_trials(seeds, |seed| simulate_policy(&programme, seed));
    print_line(&format!("  all limits at once: the cost with the weights {WEIGHTS:?}"));
    print_line(&figures.to_row("dynamic programming for these", schema, &prices));
    print_line(&format!(
        "  the programme expects {:.3}: no policy's worst ratio over limit is less",
        programme.mean_cost()
    ));
}
