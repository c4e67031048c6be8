//! The search for the values of the base policy, on trials that are not used for judging.

use barrelman_sim::noise;

use super::super::model_figures::{Figures, Prices};
use super::policy::{BasePolicy, BaseValues};
use super::target::TargetPath;
use super::world::simulate_policy;
use crate::parallel;

/// The first seed of the search, and its trials.
const FIRST_SEED: u64 = 3_001;
const TRIALS: u64 = 24;
/// Values that are tried, and the seed of their changes.
const ROUNDS: u64 = 400;
const SEARCH_SEED: u64 = 1;
/// How many values a round changes on average.
const MEAN_CHANGES: f64 = 2.5;

/// The values with the least cost, found by a random walk whose steps shrink.
pub(super) fn best_values(prices: &Prices) -> BaseValues {
    let seeds: Vec<u64> = (FIRST_SEED..FIRST_SEED + TRIALS).collect();
    let paths = parallel::map(&seeds, |seed| TargetPath::of_seed(*seed));
    let cost = |values: BaseValues| {
        let costs = parallel::map(&paths, |path| {
            prices.cost_of(&simulate_policy(&mut BasePolicy::new(values), path))
        });
        costs.iter().sum::<f64>() / TRIALS as f64
    };
    let mut best = BaseValues::FIRST;
    let mut min_cost = cost(best);
    for round in 0..ROUNDS {
        let share = 1.0 - round as f64 / ROUNDS as f64;
        let candidate = changed(best, 0.02 + 0.25 * share, |index| noise::unit(SEARCH_SEED, round, index));
        let found = cost(candidate);
        if found < min_cost {
            (best, min_cost) = (candidate, found);
        }
    }
    best
}

/// Values of which a few are changed, by at most `step` of their ranges.
fn changed(mut values: BaseValues, step: f64, random: impl Fn(u64) -> f64) -> BaseValues {
    let ranges = values.ranges();
    let chance = MEAN_CHANGES / ranges.len() as f64;
    for (index, (value, [low, high])) in (0_u64..).zip(ranges) {
        if random(2 * index) < chance {
            *value = (*value + step * (high - low) * (2.0 * random(2 * index + 1) - 1.0)).clamp(low, high);
        }
    }
    values
}

/// Mean figures of the base policy with these values.
pub(super) fn figures_of(values: BaseValues, seeds: core::ops::Range<u64>) -> Figures {
    Figures::mean_of_trials(seeds, |seed| {
        simulate_policy(&mut BasePolicy::new(values), &TargetPath::of_seed(seed))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_values_stay_in_their_ranges() {
        for round in 0..50 {
            let mut values = changed(BaseValues::FIRST, 1.0, |index| noise::unit(7, round, index));
            for (value, [low, high]) in values.ranges() {
                assert!((low..=high).contains(value), "{value}");
            }
        }
    }
}
