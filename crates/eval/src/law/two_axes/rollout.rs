//! A policy that improves on another one by rollouts (receding horizon, with sampled futures).
//!
//! At each decision, every plan of [`plans`] is followed to its end and then the base policy, up to the horizon, against
//! the same sampled futures of the target. All plans meet a few futures, the best of them more. The first command of
//! the best plan is given if that plan is surely better than the base policy, else the base policy's; at the next
//! decision all begins anew. So the result is better than the base policy, up to the errors of sampling and of the end
//! of the horizon (Bertsekas, *Rollout, Policy Iteration, and Distributed Reinforcement Learning*, 2020).
//!
//! A future starts now; a command acts a dead time later. What happens until then is the same for all plans and is
//! not counted.

use super::super::axis_model::{Axis, AxisStep, DEAD_TIME_S, STEP_S, STEPS_PER_SECOND};
use super::super::model_figures::Prices;
use super::plans::{Plan, plans};
use super::policy::{BasePolicy, Policy, Prospect, Situation};
use super::target::{SeenBearing, Target, TargetPath, TargetStep};
use super::world::TICKS_PER_POLICY_STEP;
use crate::rng::Rng;
use crate::statistics::mean;

/// The horizon, in decisions.
const HORIZON: usize = 8 * STEPS_PER_SECOND as usize;
/// The dead time, in decisions.
const DEAD_STEPS: usize = (DEAD_TIME_S * STEPS_PER_SECOND as f64 + 0.5) as usize;
/// Futures that all plans meet, and how many plans meet all the [`FUTURES`].
const FIRST_FUTURES: usize = 16;
const FINALISTS: usize = 4;
const FUTURES: usize = 64;

/// A plan must be better than the base policy by this many standard errors: among many plans, the one that looks best is
/// partly lucky.
const SURENESS: f64 = 3.0;

/// A camera at rest goes on resting, without rollouts, while the target is expected within this radius, this many seconds
/// after the effect of a command.
const CALM_RADIUS: f64 = 0.6;
const CALM_LOOK_AHEAD_S: f64 = 0.5;

/// What is known of the target's future.
pub(super) enum Foresight<'a> {
    /// The model.
    Model(Rng),
    /// The path itself.
    Path(&'a TargetPath),
}

/// The policy.
pub(super) struct RolloutPolicy<'a> {
    base: BasePolicy,
    prices: Prices,
    foresight: Foresight<'a>,
    step: AxisStep,
}

/// A future: at each decision what the base policy predicts, and how the target is seen.
struct Future(Vec<(Prospect, SeenBearing)>);

impl<'a> RolloutPolicy<'a> {
    pub(super) fn new(base: BasePolicy, prices: Prices, foresight: Foresight<'a>) -> Self {
        Self { base, prices, foresight, step: AxisStep::of_duration(STEP_S) }
    }

    /// The futures that plans are compared in.
    fn futures(&mut self, now: &Target, tick: usize) -> Vec<Future> {
        let base = self.base;
        let steps = HORIZON + DEAD_STEPS;
        match &mut self.foresight {
            Foresight::Path(path) => {
                let states = (0..steps).map(|step| path.at(tick + step * TICKS_PER_POLICY_STEP));
                vec![Future::of(&base, states)]
            }
            Foresight::Model(rng) => {
                let step = TargetStep::of_duration(STEP_S);
                let deviates: Vec<[f64; 2]> = (0..steps * FUTURES / 2)
                    .map(|_| [rng.approximately_normal(), rng.approximately_normal()])
                    .collect();
                // Each future has another one with all deviates reversed.
                let signed = |deviates: &[[f64; 2]], sign: f64| {
                    let mut target = *now;
                    Future::of(
                        &base,
                        deviates.iter().map(|pair| {
                            let state = target;
                            target = state.after(step, pair.map(|deviate| sign * deviate));
                            state
                        }),
                    )
                };
                deviates.chunks(steps).flat_map(|part| [1.0, -1.0].map(|sign| signed(part, sign))).collect()
            }
        }
    }

    /// The cost of a plan in each of these futures, up to the horizon.
    fn costs(&self, plan: &Plan, situation: &Situation, futures: &[Future]) -> Vec<f64> {
        futures.iter().map(|future| self.cost_in(plan, situation, future)).collect()
    }

    fn cost_in(&self, plan: &Plan, situation: &Situation, Future(states): &Future) -> f64 {
        let Situation { mut ahead, mut command, .. } = *situation;
        let mut cost = 0.0;
        for step in 0..HORIZON {
            let rates =
                plan.rates_at(step).unwrap_or_else(|| self.base.rates(&states[step].0, ahead, command));
            cost += self.prices.of_change(command, rates) + STEP_S * self.prices.of_rates(rates);
            command = rates;
            let is_outside = states[step + DEAD_STEPS].1.radius(ahead.map(|axis| axis.angle)) > 1.0;
            cost += STEP_S * self.prices.of_outside() * f64::from(u8::from(is_outside));
            ahead = [0, 1].map(|axis| ahead[axis].after_step(rates[axis], self.step));
        }
        cost
    }
}

impl Future {
    fn of(base: &BasePolicy, states: impl Iterator<Item = Target>) -> Self {
        Self(states.map(|state| (base.prospect(&state), SeenBearing::of(state.bearing))).collect())
    }
}

impl Policy for RolloutPolicy<'_> {
    fn decide(&mut self, situation: &Situation, tick: usize) -> [f64; 2] {
        let calm = SeenBearing::of(BasePolicy::aim(&situation.target, CALM_LOOK_AHEAD_S));
        if situation.command == [0.0; 2] && calm.radius(situation.ahead.map(Axis::rest_angle)) < CALM_RADIUS {
            return [0.0; 2];
        }
        let futures = self.futures(&situation.target, tick);
        let first = &futures[..FIRST_FUTURES.min(futures.len())];
        let plans = plans(&self.base, situation);
        let Some((base_plan, others)) = plans.split_first() else { return [0.0; 2] };
        let mut ranked: Vec<(f64, &Plan)> =
            others.iter().map(|plan| (mean(&self.costs(plan, situation, first)), plan)).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let base_costs = self.costs(base_plan, situation, &futures);
        let best = ranked
            .iter()
            .take(FINALISTS)
            .map(|(_, plan)| (upper_gain(&self.costs(plan, situation, &futures), &base_costs), *plan))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(gain, _)| *gain < 0.0);
        best.and_then(|(_, plan)| plan.rates_at(0)).unwrap_or_else(|| self.base.decide(situation, tick))
    }
}

/// What a plan costs more than the base policy in the same futures: the mean, and [`SURENESS`] standard errors more.
fn upper_gain(costs: &[f64], base_costs: &[f64]) -> f64 {
    let differences: Vec<f64> = costs.iter().zip(base_costs).map(|(cost, base)| cost - base).collect();
    let centre = mean(&differences);
    let squares: Vec<f64> = differences.iter().map(|difference| (difference - centre).powi(2)).collect();
    centre + SURENESS * (mean(&squares) / costs.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_must_be_surely_better_than_the_base_policy() {
        let base = [1.0, 2.0, 3.0, 4.0];
        assert!(upper_gain(&base.map(|cost| cost - 0.1), &base) < 0.0);
        // Better by 0.1 in the mean, with a standard error of 0.5.
        assert!(upper_gain(&[-0.1, 2.9, 1.9, 4.9], &base) > 0.0);
    }
}
