//! The plans that rollouts compare.

use super::super::axis_model::{Axis, MAX_RATE};
use super::policy::{BasePolicy, Situation};

/// Rates that are held for a number of decisions each, one after the other; the base policy goes on from there.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Plan(Vec<([f64; 2], usize)>);

impl Plan {
    /// The rates at a decision, rad/s, counted from the first; `None` where the base policy decides.
    pub(super) fn rates_at(&self, mut step: usize) -> Option<[f64; 2]> {
        for (rates, steps) in &self.0 {
            if step < *steps {
                return Some(*rates);
            }
            step -= steps;
        }
        None
    }
}

const REST: [f64; 2] = [0.0; 2];
/// How long a camera at rest may wait, and a movement may go on, decisions.
const WAITS: [usize; 4] = [1, 4, 9, 16];
const HOLDS: [usize; 3] = [2, 5, 10];
/// How far ahead a movement may aim, seconds, and its rates, rad/s.
const AIMS_S: [f64; 2] = [0.3, 1.2];
const RATES: [f64; 3] = [0.2, 0.28, MAX_RATE];
/// The aim and the rate of a movement that only one axis makes, and of one that is changed.
const USUAL_AIM_S: f64 = 0.7;
const USUAL_RATE: f64 = 0.28;

/// All plans for a situation; the first one is the base policy.
pub(super) fn plans(base: &BasePolicy, situation: &Situation) -> Vec<Plan> {
    let Situation { target, ahead, command } = situation;
    let pointing = ahead.map(Axis::rest_angle);
    let towards = |aim_s: f64, rate: f64| base.towards(BasePolicy::aim(target, aim_s), pointing, rate);
    let usual = towards(USUAL_AIM_S, USUAL_RATE);
    let mut plans = vec![Plan::default()];
    let mut begin = |rates: [f64; 2], steps: usize| {
        if rates != REST {
            plans.push(Plan(vec![(rates, steps)]));
        }
    };
    if *command == REST {
        for rates in AIMS_S.iter().flat_map(|aim_s| RATES.map(|rate| towards(*aim_s, rate))) {
            begin(rates, 1);
        }
        begin([usual[0], 0.0], 1);
        begin([0.0, usual[1]], 1);
        plans.extend(WAITS.map(|steps| Plan(vec![(REST, steps)])));
    } else {
        let [pan, tilt] = *command;
        // One axis stops, one joins, both change.
        for rates in [[pan, 0.0], [0.0, tilt], [pan, usual[1]], [usual[0], tilt], usual] {
            begin(rates, 1);
        }
        for steps in HOLDS {
            begin(*command, steps);
        }
        plans.push(Plan(vec![(REST, 1)]));
        plans.extend(HOLDS.map(|steps| Plan(vec![(*command, steps), (REST, 1)])));
    }
    plans
}

#[cfg(test)]
mod tests {
    use super::super::policy::BaseValues;
    use super::super::target::Target;
    use super::*;

    #[test]
    fn a_plan_holds_its_rates_one_after_the_other_and_ends() {
        let plan = Plan(vec![([0.2, 0.0], 2), (REST, 1)]);
        let rates: Vec<Option<[f64; 2]>> = (0..4).map(|step| plan.rates_at(step)).collect();
        assert_eq!(rates, [Some([0.2, 0.0]), Some([0.2, 0.0]), Some(REST), None]);
    }

    #[test]
    fn the_base_policy_is_the_first_plan_at_rest_and_in_motion() {
        let base = BasePolicy::new(BaseValues::FIRST);
        for command in [REST, [0.2, 0.1]] {
            let target = Target { bearing: [0.6, 0.1], rates: [0.1, 0.0] };
            let ahead = [Axis { angle: 0.0, rate: 0.0 }; 2];
            let plans = plans(&base, &Situation { target, ahead, command });
            assert_eq!(plans[0], Plan::default());
            assert!(plans.len() > 8);
        }
    }
}
