//! Fits the motion of the simulated laboratory target to the recorded targets.
//!
//! *Compared* are the statistics of [`super::motion`]: the means over the trials, and the spread of some of
//! them, in standard errors of the recorded values. Statistics that say nearly the same form a group that
//! counts as one. From three standard errors on the loss of a statistic grows only linearly (Huber's loss),
//! so that a statistic that the script cannot reproduce does not decide about the others. The region, P and
//! excursions are not used.
//!
//! *Fitted* are the target's speed and its variation, how much it slows down in turns and where it arrives,
//! how closely it follows its path, how long it stands, and the distance and breadth of the path. Plant,
//! optics, sway and noise stay.
//!
//! The search is a separable CMA-ES, started several times from different points. All random numbers follow
//! from fixed seeds, so that the same call gives the same fit. All candidates are simulated with the same
//! seeds, below 10,000; they represent the speeds and standing times of many trials, because a few dozen
//! consecutive seeds may happen to be slow.

mod evolution_strategy;
mod objective;
mod parameters;
mod representative_seeds;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use barrelman_experiments::campaign::runner::run_in_order;
use barrelman_sim::noise;
use barrelman_sim::scenario::TargetScript;

use super::laboratory::{load_scenario, read_recorded};
use super::motion::MotionStatistics;
use super::options::FitOptions;
use crate::output::print_line;
use evolution_strategy::EvolutionStrategy;
use objective::Objective;
use parameters::{PARAMETERS, ScaledScript, UnitPoint, at_point, to_point};
use representative_seeds::representative_seeds;

/// Step sizes of the first search, which starts from the scenario's values, and of those that start anywhere.
const LOCAL_STEP_SIZE: f64 = 0.15;
const GLOBAL_STEP_SIZE: f64 = 0.3;
/// Seed of the points from which the other searches start.
const START_SEED: u64 = 8;

/// A point with its misfit.
#[derive(Clone, Copy)]
struct Evaluated {
    misfit: f64,
    point: UnitPoint,
}

/// Fits, and prints the values for the scenario's file.
pub(super) fn run(folder: &Path, options: &FitOptions) -> Result<()> {
    let scenario = load_scenario(options.arena, options.scenarios.as_deref())?;
    let recorded: Vec<_> = read_recorded(folder, options.arena, false)?
        .iter()
        .map(|log| MotionStatistics::from_log(log, &scenario))
        .collect();
    let TargetScript::Pursuit(pursuit) = scenario.target.clone() else {
        anyhow::bail!("the target of {} does not pursue a path", scenario.name);
    };
    let initial = ScaledScript::unscaled(pursuit);
    let objective = Objective::new(scenario, initial, &recorded, representative_seeds(options.seeds));
    let start = to_point(&objective.initial);
    let mut best = Evaluated { misfit: objective.evaluate(&start)?, point: start };
    print_line(&format!("as it is: misfit {:.1}", best.misfit));
    for search in 0..options.starts {
        let (point, step_size) = match search {
            0 => (start, LOCAL_STEP_SIZE),
            _ => {
                (std::array::from_fn(|index| noise::unit(START_SEED, search, index as u64)), GLOBAL_STEP_SIZE)
            }
        };
        let mut strategy = EvolutionStrategy::new(point, step_size, search);
        let mut min_misfit = f64::INFINITY;
        for _ in 0..options.generations {
            let candidates = evaluate_generation(&objective, &strategy, options.threads)?;
            let first = *candidates.first().context("no candidate was evaluated")?;
            min_misfit = min_misfit.min(first.misfit);
            if first.misfit < best.misfit {
                best = first;
            }
            let best_first: Vec<UnitPoint> =
                candidates.into_iter().map(|candidate| candidate.point).collect();
            strategy.update(&best_first);
        }
        print_line(&format!(
            "search {}: misfit {min_misfit:.1}, last step {:.3}",
            search + 1,
            strategy.step_size()
        ));
    }
    print_fit(&objective, &best)
}

/// The candidates of a generation in the order of their misfits, the best first.
fn evaluate_generation(
    objective: &Objective,
    strategy: &EvolutionStrategy,
    threads: usize,
) -> Result<Vec<Evaluated>> {
    let candidates = strategy.candidates();
    let numbers: Vec<u64> = (0..candidates.len() as u64).collect();
    let mut evaluated = Vec::with_capacity(candidates.len());
    run_in_order(
        &numbers,
        threads,
        &AtomicBool::new(false),
        |number| {
            let point = candidates[number as usize];
            Ok(Evaluated { misfit: objective.evaluate(&point)?, point })
        },
        |candidate| {
            evaluated.push(candidate);
            Ok(())
        },
    )?;
    evaluated.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    Ok(evaluated)
}

/// Prints the compared figures and the fitted parameters.
fn print_fit(objective: &Objective, best: &Evaluated) -> Result<()> {
    let simulated = objective.simulate(&best.point)?;
    print_line(&format!(
        "\nmisfit {:.1} over {} groups of figures\n{:32} {:>10} {:>8} {:>10} {:>8}",
        best.misfit,
        objective.groups().count(),
        "",
        "recorded",
        "+-",
        "simulated",
        "errors"
    ));
    for (index, figure) in objective.figures.iter().enumerate() {
        let (recorded, error, simulated) =
            (objective.recorded[index], objective.standard_errors[index], simulated[index]);
        print_line(&format!(
            "{:32} {recorded:>10.3} {error:>8.3} {simulated:>10.3} {:>+8.1}",
            figure.name,
            (simulated - recorded) / error
        ));
    }
    let mut script = at_point(&objective.initial, &best.point);
    print_line("\n[target], its scale and its breadth to be multiplied with the file's");
    for (name, _, _, field) in PARAMETERS {
        print_line(&format!("{name} = {:.3}", *field(&mut script)));
    }
    Ok(())
}
