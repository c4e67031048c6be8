//! What is gained by moving the camera only when the target leaves a region: the schema against a PID on the picture's
//! centre, on the same seeds.

use anyhow::{Context, Result};
use barrelman_experiments::law_choice::{LawChoice, LawName};
use barrelman_trial::campaign::statistics::Bootstrap;
use barrelman_trial::metrics::{TrialMetrics, measure};

use super::Options;
use super::recorded::{plan, region};
use crate::say;

/// A figure: its name and what of a trial it is.
type Figure = (&'static str, fn(&TrialMetrics) -> Option<f64>);

const FIGURES: [Figure; 6] = [
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
        let trials = |law| -> Result<Vec<TrialMetrics>> {
            let plan = plan(arena, options.scenarios.as_deref(), law, None)?;
            (options.first_seed..options.first_seed + options.seeds)
                .map(|seed| {
                    let log = plan.simulate(seed, &mut ())?;
                    Ok(measure(&log, region(&log), log.picture))
                })
                .collect()
        };
        let (schema, centre) = (trials(LawChoice::MOTOR_SCHEMA)?, trials(LawChoice::new(LawName::Centring))?);
        say(&format!(
            "\n{:34} {:>10} {:>10} {:>34}",
            format!("arena {arena}, {} pairs", schema.len()),
            "schema",
            "centre",
            "schema less centre, 95 % of pairs"
        ));
        for (name, of) in FIGURES {
            let pairs: Vec<(f64, f64)> =
                schema.iter().zip(&centre).filter_map(|(a, b)| of(a).zip(of(b))).collect();
            let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
            let difference = Bootstrap::DEFAULT
                .interval(pairs.len(), |taken| {
                    taken.iter().map(|pair| pairs[*pair].0 - pairs[*pair].1).sum::<f64>() / taken.len() as f64
                })
                .context("no trial has the figure")?;
            say(&format!(
                "{name:34} {:>10.2} {:>10.2} {:>34}",
                mean(|pair| pair.0),
                mean(|pair| pair.1),
                format!("{:.2} ({:.2} to {:.2})", difference.value, difference.low, difference.high)
            ));
        }
    }
    Ok(())
}
