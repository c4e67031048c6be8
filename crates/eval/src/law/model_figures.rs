//! What a law did in a model of one or two axes, and what that costs.

use barrelman_sim::tick::TICK_S;

use crate::parallel;
use crate::statistics::mean;

/// Duration of a trial, seconds.
pub(super) const TRIAL_S: f64 = 120.0;

/// The limits of the ratios to the schema, in the order of [`Figures::in_order`].
pub(super) const LIMITS: [f64; 6] = [0.6, 0.85, 1.0, 1.0, 1.0, 1.0];
/// Names of the figures, in the same order.
pub(super) const NAMES: [&str; 6] = ["outside", "rate2", "moves", "|rate|", "moving", "variation"];

/// What a law did, for each second. Sums are over the axes; a movement is one of any axis, and starts where all rested.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Figures {
    /// Share of the time outside.
    outside: f64,
    /// rad²/s².
    rate_squared: f64,
    starts: f64,
    /// rad/s.
    rate: f64,
    /// Share of the time with a command.
    moving: f64,
    /// rad/s².
    variation: f64,
}

impl Figures {
    pub(super) const fn in_order(&self) -> [f64; 6] {
        [self.outside, self.rate_squared, self.starts, self.rate, self.moving, self.variation]
    }

    pub(super) const fn from_order(
        [outside, rate_squared, starts, rate, moving, variation]: [f64; 6],
    ) -> Self {
        Self { outside, rate_squared, starts, rate, moving, variation }
    }

    /// The mean over the trials of some seeds.
    pub(super) fn mean_of_trials(
        seeds: core::ops::Range<u64>,
        simulate: impl Fn(u64) -> Self + Sync,
    ) -> Self {
        let seeds: Vec<u64> = seeds.collect();
        let trials = parallel::map(&seeds, |seed| simulate(*seed).in_order());
        let mean_of = |index: usize| mean(&trials.iter().map(|trial| trial[index]).collect::<Vec<f64>>());
        Self::from_order([0, 1, 2, 3, 4, 5].map(mean_of))
    }

    /// Adds a tick with the axes' commands in force, rad/s.
    pub(super) fn add_tick<const AXES: usize>(&mut self, is_outside: bool, rates: [f64; AXES]) {
        let share = TICK_S / TRIAL_S;
        self.outside += share * f64::from(u8::from(is_outside));
        for rate in rates {
            self.rate_squared += share * rate * rate;
            self.rate += share * rate.abs();
        }
        self.moving += share * f64::from(u8::from(is_motion(rates)));
    }

    /// Adds a change of the axes' commands, rad/s.
    pub(super) fn add_change<const AXES: usize>(&mut self, before: [f64; AXES], rates: [f64; AXES]) {
        self.variation += change(before, rates) / TRIAL_S;
        self.starts += f64::from(u8::from(!is_motion(before) && is_motion(rates))) / TRIAL_S;
    }

    /// The ratios to the schema's figures as cells of a table, and the cost.
    pub(super) fn to_row(self, name: &str, schema: &Self, prices: &Prices) -> String {
        let ratios: Vec<String> = self
            .in_order()
            .iter()
            .zip(schema.in_order())
            .map(|(figure, schema)| format!("{:9.3}", figure / schema))
            .collect();
        format!("  {name:30} {} {:7.3}", ratios.join(" "), prices.cost_of(&self))
    }
}

/// The head of a table of [`Figures::to_row`].
pub(super) fn table_head() -> String {
    format!("  {:30} {}    cost", "", NAMES.map(|name| format!("{name:>9}")).join(" "))
}

fn is_motion<const AXES: usize>(rates: [f64; AXES]) -> bool {
    rates.iter().any(|rate| *rate != 0.0)
}

fn change<const AXES: usize>(before: [f64; AXES], rates: [f64; AXES]) -> f64 {
    before.iter().zip(rates).map(|(before, rate)| (rate - before).abs()).sum()
}

/// What a unit of each figure costs, in the order of [`Figures::in_order`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Prices([f64; 6]);

impl Prices {
    /// Prices such that the cost is the mean, over the figures, of the ratio to `schema` divided by its limit.
    pub(super) fn of_ratios(schema: &Figures) -> Self {
        Self::of_weighted_ratios(schema, [1.0 / 6.0; 6])
    }

    /// Prices such that the cost is the sum, over the figures, of weight times the ratio to `schema` divided by its limit.
    pub(super) fn of_weighted_ratios(schema: &Figures, weights: [f64; 6]) -> Self {
        let figures = schema.in_order();
        Self([0, 1, 2, 3, 4, 5].map(|index| weights[index] / (LIMITS[index] * figures[index])))
    }

    pub(super) fn cost_of(&self, figures: &Figures) -> f64 {
        self.0.iter().zip(figures.in_order()).map(|(price, figure)| price * figure).sum()
    }

    /// The cost of a second outside.
    pub(super) const fn of_outside(&self) -> f64 {
        self.0[0]
    }

    /// The cost of a second with these commands, rad/s.
    pub(super) fn of_rates<const AXES: usize>(&self, rates: [f64; AXES]) -> f64 {
        let by_axis = |rate: &f64| self.0[1] * rate * rate + self.0[3] * rate.abs();
        let moving = f64::from(u8::from(is_motion(rates)));
        rates.iter().map(by_axis).sum::<f64>() + self.0[4] * moving
    }

    /// The cost of a change of the commands, rad/s.
    pub(super) fn of_change<const AXES: usize>(&self, before: [f64; AXES], rates: [f64; AXES]) -> f64 {
        let starts = f64::from(u8::from(!is_motion(before) && is_motion(rates)));
        self.0[2] * starts + self.0[5] * change(before, rates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cost_of_figures_is_that_of_their_seconds_and_changes() {
        let prices = Prices([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let (rest, motion) = ([0.0, 0.0], [0.2, -0.1]);
        let mut figures = Figures::default();
        figures.add_change(rest, motion);
        figures.add_tick(true, motion);
        figures.add_change(motion, rest);
        figures.add_tick(false, rest);
        let seconds = TICK_S * (prices.of_outside() + prices.of_rates(motion));
        let changes = prices.of_change(rest, motion) + prices.of_change(motion, rest);
        assert!((prices.cost_of(&figures) - (seconds + changes) / TRIAL_S).abs() < 1e-12);
    }

    #[test]
    fn an_axis_that_joins_a_movement_is_no_start() {
        let mut figures = Figures::default();
        for (before, rates) in [([0.0, 0.0], [0.2, 0.0]), ([0.2, 0.0], [0.2, 0.1]), ([0.2, 0.1], [0.0, 0.0])]
        {
            figures.add_change(before, rates);
        }
        assert!((figures.in_order()[2] * TRIAL_S - 1.0).abs() < 1e-9);
    }
}
