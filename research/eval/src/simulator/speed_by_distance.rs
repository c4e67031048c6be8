//! The table `distance`: the target's speed in the picture where it is far, in between and near, recorded and
//! simulated.
//!
//! A target with one speed over the floor moves slowly in the picture where it is far. The recorded targets
//! slow down less than that; the simulated target's `range_exponent` reproduces them. The last row of each
//! arena leaves it out.

use std::path::Path;

use anyhow::Result;
use barrelman_sim::Scenario;
use barrelman_sim::scenario::TargetScript;
use barrelman_trial::logs::TrialLog;

use super::laboratory::{load_scenario, read_recorded, simulate_all};
use super::motion::{MovingSample, moving_samples};
use super::options::Options;
use crate::output::print_line;
use crate::statistics::{mean, quantile};

/// Quantiles of the recorded depression that part far, in between and near.
const EDGES: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];
/// Simulated trials of each kind.
const TRIALS: u64 = 48;

/// Prints the table.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    print_line(
        "\nMean speed of a target under way, by how far it is: pixels per second in thirds of the recorded time",
    );
    print_line(&format!("{:44} {:>10} {:>10} {:>10}", "", "far", "between", "near"));
    for arena in [1, 2] {
        let scenario = load_scenario(arena, options.scenarios.as_deref())?;
        let mut same_everywhere = scenario.clone();
        if let TargetScript::Pursuit(script) = &mut same_everywhere.target {
            script.range_exponent = 0.0;
        }
        let simulated =
            |scenario: &Scenario| simulate_all(scenario, options.first_seed..options.first_seed + TRIALS);
        // The plant is the same with and without the range exponent.
        let moving = |logs: &[TrialLog]| -> Vec<MovingSample> {
            logs.iter().flat_map(|log| moving_samples(log, &scenario)).collect()
        };
        let recorded = moving(&read_recorded(folder, arena, false)?);
        let depressions: Vec<f64> = recorded.iter().map(|sample| sample.depression_rad).collect();
        let edges = EDGES.map(|share| quantile(&depressions, share));
        print_row(&format!("arena {arena}, recorded"), &recorded, edges);
        print_row(&format!("arena {arena}, simulated"), &moving(&simulated(&scenario)?), edges);
        print_row(
            &format!("arena {arena}, were it as fast everywhere"),
            &moving(&simulated(&same_everywhere)?),
            edges,
        );
    }
    Ok(())
}

fn print_row(name: &str, samples: &[MovingSample], edges: [f64; 2]) {
    let mut thirds: [Vec<f64>; 3] = Default::default();
    for sample in samples {
        let third = edges.iter().filter(|edge| sample.depression_rad >= **edge).count();
        thirds[third].push(sample.speed_px_per_s);
    }
    let [far, between, near] = thirds.map(|speeds| format!("{:.1}", mean(&speeds)));
    print_line(&format!("{name:44} {far:>10} {between:>10} {near:>10}"));
}
