//! How fast the target goes where it is far from the camera, and where it is near: recorded and simulated.
//!
//! A thing that is moved over the floor at one speed crawls through the picture where it is far. The recorded targets do
//! so by less than that.

use std::path::Path;

use anyhow::Result;
use barrelman_sim::Scenario;
use barrelman_sim::scenario::TargetScript;
use barrelman_trial::logs::TrialLog;

use super::Options;
use super::motion;
use super::recorded::{read, scenario, simulated_from};
use crate::say;
use crate::tracker::figures::{mean, quantile};

/// Thirds of the time under way, by the recorded depression: far, in between, near.
const SHARES: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];
/// Simulated trials of each kind.
const TRIALS: u64 = 48;

/// Prints the table.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    say(
        "\nMean speed of a target under way, by how far it is: pixels per second in thirds of the recorded time",
    );
    say(&format!("{:44} {:>10} {:>10} {:>10}", "", "far", "between", "near"));
    for arena in [1, 2] {
        let scenario = scenario(arena, options.scenarios.as_deref())?;
        let mut same_everywhere = scenario.clone();
        if let TargetScript::Pursuit(script) = &mut same_everywhere.target {
            script.range_exponent = 0.0;
        }
        let trials = |scenario: &Scenario| simulated_from(scenario, options.first_seed, TRIALS);
        let under_way = |logs: Vec<TrialLog>| -> Vec<(f64, f64)> {
            logs.iter().flat_map(|log| motion::under_way(log, &scenario)).collect()
        };
        let recorded = under_way(read(folder, arena, false)?.into_iter().map(|trial| trial.log).collect());
        let depressions: Vec<f64> = recorded.iter().map(|(depression, _)| *depression).collect();
        let edges = SHARES.map(|share| quantile(&depressions, share));
        row(&format!("arena {arena}, recorded"), &recorded, edges);
        row(&format!("arena {arena}, simulated"), &under_way(trials(&scenario)?), edges);
        row(
            &format!("arena {arena}, were it as fast everywhere"),
            &under_way(trials(&same_everywhere)?),
            edges,
        );
    }
    Ok(())
}

fn row(name: &str, under_way: &[(f64, f64)], edges: [f64; 2]) {
    let mut thirds: [Vec<f64>; 3] = Default::default();
    for (depression, speed) in under_way {
        thirds[edges.iter().filter(|edge| depression >= edge).count()].push(*speed);
    }
    let [far, between, near] = thirds.map(|speeds| format!("{:.1}", mean(&speeds)));
    say(&format!("{name:44} {far:>10} {between:>10} {near:>10}"));
}
