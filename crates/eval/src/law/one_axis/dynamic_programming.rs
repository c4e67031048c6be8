//! The policy with the least mean cost, by relative value iteration.
//!
//! The state at the *effect time* of a command given now: the target's predicted offset z from the axis and its rate v, the
//! axis' rate w, and the command in force. In a step of a tenth of a second, with c the decay of the bearing's rate, D the dead time,
//! τ the lag, and n a normal deviate:
//!
//! ```text
//! v' = c v + s n        z' = z + T (1 − c) v + T (1 − e^(−D/T)) e^(D/T) s n − ∫ w
//! w' = u + (w − u) e^(−step/τ)
//! ```
//! The new knowledge n comes a dead time before its effect; s is that of the rate at the effect time. The offset itself
//! differs from its prediction by what the target does within the dead time; its chance of being outside is a difference of
//! two normal distributions. Values are interpolated linearly on a grid, and n takes five values. The grid makes the result an
//! approximation: what the programme expects and what its policy costs in the simulation differ by a few per cent.

use crate::parallel;

use super::super::axis_model::{
    Axis, DEAD_TIME_S, MAX_RATE, RATE_STD_DEV, RATE_TIME_CONSTANT_S, STEP_S, edge,
};
use super::super::model_figures::Prices;

/// The commands, rad/s.
const RATES: [f64; 7] = [-MAX_RATE, -0.28, -0.2, 0.0, 0.2, 0.28, MAX_RATE];

/// The grid: the largest value of each coordinate, and the points on each side of zero.
const REACH: [f64; 3] = [1.4, 0.42, MAX_RATE];
const SIDE: [usize; 3] = [60, 14, 6];
const COUNT: [usize; 3] = [2 * SIDE[0] + 1, 2 * SIDE[1] + 1, 2 * SIDE[2] + 1];
const STATES: usize = COUNT[0] * COUNT[1] * COUNT[2];

/// Points and weights of the Gauss-Hermite rule for a standard normal deviate.
const DEVIATES: [(f64, f64); 5] = [
    (-2.856_970_013_872_806, 0.011_257_411_327_720_7),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (2.856_970_013_872_806, 0.011_257_411_327_720_7),
];

/// Most sweeps over the grid, and the spread of the changes at which they end, in cost.
const MAX_SWEEPS: usize = 1500;
const TOLERANCE: f64 = 2e-3;

/// The solved problem.
pub(super) struct DynamicProgramme {
    prices: Prices,
    /// Cost still to come after a command, above the mean: by command, then by state.
    costs: Vec<Vec<f64>>,
    mean_cost: f64,
}

impl DynamicProgramme {
    /// Finds the policy with the least mean cost.
    pub(super) fn solve(prices: &Prices) -> Self {
        let commands: Vec<usize> = (0..RATES.len()).collect();
        let mut values = vec![vec![0.0; STATES]; RATES.len()];
        let mut programme = Self { prices: *prices, costs: Vec::new(), mean_cost: 0.0 };
        for _ in 0..MAX_SWEEPS {
            programme.costs =
                parallel::map(&commands, |index| programme.after_command(*index, &values[*index]));
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            let reference = programme.value(middle(), 0.0);
            for (before, values) in RATES.iter().zip(&mut values) {
                for (state, value) in values.iter_mut().enumerate() {
                    let next = programme.value(state, *before);
                    least = least.min(next - *value);
                    most = most.max(next - *value);
                    *value = next;
                }
            }
            programme.mean_cost = 0.5 * (least + most) / STEP_S;
            for value in values.iter_mut().flatten() {
                *value -= reference;
            }
            if (most - least) / STEP_S < TOLERANCE {
                break;
            }
        }
        programme
    }

    /// The mean cost of the policy for each second, as the programme expects it.
    pub(super) const fn mean_cost(&self) -> f64 {
        self.mean_cost
    }

    /// The best command for a state.
    pub(super) fn decide(&self, offset: f64, bearing_rate: f64, axis_rate: f64, before: f64) -> f64 {
        let place = Place::of([offset, bearing_rate, axis_rate]);
        let cost = |index: &usize| {
            place.interpolate(&self.costs[*index]) + self.prices.of_change([before], [RATES[*index]])
        };
        let best = (0..RATES.len()).min_by(|a, b| cost(a).total_cmp(&cost(b)));
        best.map_or(0.0, |index| RATES[index])
    }

    /// The cost to come in a state with a command in force.
    fn value(&self, state: usize, before: f64) -> f64 {
        RATES
            .iter()
            .zip(&self.costs)
            .map(|(rate, costs)| costs[state] + self.prices.of_change([before], [*rate]))
            .fold(f64::INFINITY, f64::min)
    }

    /// For each state: the cost of a step with a command, and of what comes after it with these values.
    fn after_command(&self, command: usize, values: &[f64]) -> Vec<f64> {
        let rate = RATES[command];
        let decay = (-STEP_S / RATE_TIME_CONSTANT_S).exp();
        let dead_time_decay = (-DEAD_TIME_S / RATE_TIME_CONSTANT_S).exp();
        // Linear interpolation adds a sixth of the squared spacing to the variance; so much less noise is needed.
        let spacing = REACH[1] / SIDE[1] as f64;
        let variance = (RATE_STD_DEV * dead_time_decay).powi(2) * (1.0 - decay * decay);
        let spread = (variance - spacing * spacing / 6.0).sqrt();
        let offset_for_spread = RATE_TIME_CONSTANT_S * (1.0 / dead_time_decay - 1.0);
        let cost_of_rate = self.prices.of_rates([rate]);
        (0..STATES)
            .map(|state| {
                let [offset, bearing_rate, axis_rate] = coordinates(state);
                let axis = Axis { angle: 0.0, rate: axis_rate }.after(rate, STEP_S);
                let onwards = offset + RATE_TIME_CONSTANT_S * (1.0 - decay) * bearing_rate - axis.angle;
                let to_come: f64 = DEVIATES
                    .iter()
                    .map(|(deviate, weight)| {
                        let new = spread * deviate;
                        let next = [onwards + offset_for_spread * new, decay * bearing_rate + new, axis.rate];
                        weight * Place::of(next).interpolate(values)
                    })
                    .sum();
                STEP_S * (self.prices.of_outside() * chance_of_outside(offset) + cost_of_rate) + to_come
            })
            .collect()
    }
}

/// The chance that the target is outside where it is predicted at this offset.
fn chance_of_outside(offset: f64) -> f64 {
    let decay = (-DEAD_TIME_S / RATE_TIME_CONSTANT_S).exp();
    let variance = RATE_STD_DEV
        * RATE_STD_DEV
        * RATE_TIME_CONSTANT_S
        * (2.0 * DEAD_TIME_S - RATE_TIME_CONSTANT_S * (3.0 - decay * (4.0 - decay)));
    let below = |bound: f64| 0.5 * libm::erfc(-bound / (2.0 * variance).sqrt());
    1.0 - (below(edge() - offset) - below(-edge() - offset))
}

/// The state in the middle of the grid.
const fn middle() -> usize {
    (SIDE[0] * COUNT[1] + SIDE[1]) * COUNT[2] + SIDE[2]
}

fn coordinates(state: usize) -> [f64; 3] {
    let indices = [state / (COUNT[1] * COUNT[2]), state / COUNT[2] % COUNT[1], state % COUNT[2]];
    [0, 1, 2].map(|axis| REACH[axis] * (indices[axis] as f64 / SIDE[axis] as f64 - 1.0))
}

/// A place between the points of the grid; beyond the grid, at its border.
struct Place {
    first: usize,
    shares: [f64; 3],
}

impl Place {
    fn of(point: [f64; 3]) -> Self {
        let mut first = 0;
        let mut shares = [0.0; 3];
        for axis in 0..3 {
            let at = (point[axis] / REACH[axis] + 1.0) * SIDE[axis] as f64;
            let at = at.clamp(0.0, (COUNT[axis] - 1) as f64);
            let index = (at as usize).min(COUNT[axis] - 2);
            shares[axis] = at - index as f64;
            first = first * COUNT[axis] + index;
        }
        Self { first, shares }
    }

    fn interpolate(&self, values: &[f64]) -> f64 {
        let [z, v, w] = self.shares;
        let (row, plane) = (COUNT[2], COUNT[1] * COUNT[2]);
        let along = |from: usize| (1.0 - w) * values[from] + w * values[from + 1];
        let across = |from: usize| (1.0 - v) * along(from) + v * along(from + row);
        (1.0 - z) * across(self.first) + z * across(self.first + plane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_is_interpolated_exactly() {
        let linear = |[z, v, w]: [f64; 3]| 1.0 + 2.0 * z - 3.0 * v + 0.5 * w;
        let values: Vec<f64> = (0..STATES).map(|state| linear(coordinates(state))).collect();
        for point in [[0.0; 3], [0.31, -0.17, 0.2], [-1.39, 0.41, -0.33]] {
            assert!((Place::of(point).interpolate(&values) - linear(point)).abs() < 1e-9, "{point:?}");
        }
        assert_eq!(coordinates(middle()), [0.0; 3]);
    }

    #[test]
    fn a_target_predicted_at_the_edge_is_outside_half_of_the_time() {
        assert!((chance_of_outside(edge()) - 0.5).abs() < 1e-6);
        assert!(chance_of_outside(0.0) < 1e-6 && chance_of_outside(2.0 * edge()) > 1.0 - 1e-6);
    }
}
