//! The table `centre`: what the motor schema saves by moving the camera only when the target leaves the
//! region, against a PID controller that keeps the target in the picture's centre, on the same seeds.

use anyhow::{Context, Result};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_trial::campaign::statistics::Bootstrap;
use barrelman_trial::metrics::TrialMetrics;
use barrelman_vocab::LawId;

use super::laboratory::{plan, simulate_and_measure};
use super::options::Options;
use crate::output::print_line;

/// A metric: its name in the table, and its value for a trial.
type Metric = (&'static str, fn(&TrialMetrics) -> Option<f64>);

const METRICS: [Metric; 6] = [
    ("moves", |m| m.moves.map(|moves| moves as f64)),
    ("integral of |rate|, rad", |m| m.travel_rad),
    ("integral of rate squared, rad2/s", |m| m.effort_rad2_per_s),
    ("share of time at rest, %", |m| m.duty.map(|duty| 100.0 * (1.0 - duty))),
    ("time outside, s", |m| Some(m.time_outside_s)),
    ("variation of the rate, rad/s", |m| m.variation_rad_per_s),
];

/// Prints the tables.
pub(super) fn run(options: &Options) -> Result<()> {
    for arena in [1, 2] {
        let trials = |law| {
            let plan = plan(arena, options.scenarios.as_deref(), law, None)?;
            simulate_and_measure(&plan, options.seed_range())
        };
        let (motor_schema, centring) =
            (trials(LawChoice::MOTOR_SCHEMA)?, trials(LawChoice::of(LawId::Centre))?);
        print_line(&format!(
            "\n{:34} {:>10} {:>10} {:>34}",
            format!("arena {arena}, {} pairs", motor_schema.len()),
            "schema",
            "centre",
            "schema less centre, 95 % of pairs"
        ));
        for (name, value) in METRICS {
            let pairs: Vec<(f64, f64)> =
                motor_schema.iter().zip(&centring).filter_map(|(a, b)| value(a).zip(value(b))).collect();
            let mean =
                |side: fn(&(f64, f64)) -> f64| pairs.iter().map(side).sum::<f64>() / pairs.len() as f64;
            let difference = Bootstrap::DEFAULT
                .interval(pairs.len(), |sample| {
                    sample.iter().map(|pair| pairs[*pair].0 - pairs[*pair].1).sum::<f64>()
                        / sample.len() as f64
                })
                .context("no trial has the figure")?;
            print_line(&format!(
                "{name:34} {:>10.2} {:>10.2} {:>34}",
                mean(|pair| pair.0),
                mean(|pair| pair.1),
                format!("{:.2} ({:.2} to {:.2})", difference.value, difference.low, difference.high)
            ));
        }
    }
    Ok(())
}
