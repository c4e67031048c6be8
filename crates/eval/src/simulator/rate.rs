//! What the schema's fixed rate does: the paper says that its sensitivities follow from 0.3 rad/s.

use anyhow::{Context, Result};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_trial::campaign::statistics::mean_interval;
use barrelman_trial::metrics::{TrialMetrics, measure};

use super::Options;
use super::recorded::{plan, region};
use crate::say;

/// Rates, rad/s.
const RATES: [f64; 11] = [0.10, 0.15, 0.20, 0.25, 0.30, 0.35, 0.40, 0.45, 0.50, 0.55, 0.60];

/// A column: its name and what of a trial it shows.
type Column = (&'static str, fn(&TrialMetrics) -> Option<f64>);

const COLUMNS: [Column; 6] = [
    ("sensitivity, 1/s", |m| m.sensitivity),
    ("b, s", |m| m.mean_b_s),
    ("time outside, %", |m| Some(100.0 * m.time_outside_s / m.duration_s)),
    ("rate squared, rad2/s", |m| m.effort_rad2_per_s),
    ("|rate|, rad", |m| m.travel_rad),
    ("moves", |m| m.moves.map(|moves| moves as f64)),
];

/// Prints the tables.
pub(super) fn run(options: &Options) -> Result<()> {
    for arena in [1, 2] {
        let mut header = format!("\narena {arena}: the schema's rate, rad/s");
        for (name, _) in COLUMNS {
            header += &format!(" {name:>20}");
        }
        say(&header);
        for rate in RATES {
            let plan = plan(arena, options.scenarios.as_deref(), LawChoice::MOTOR_SCHEMA, Some(rate))?;
            let metrics: Vec<TrialMetrics> = (options.first_seed..options.first_seed + options.seeds)
                .map(|seed| {
                    let log = plan.simulate(seed, &mut ())?;
                    Ok(measure(&log, region(&log), log.picture))
                })
                .collect::<Result<_>>()?;
            let mut line = format!("{rate:>35.2}");
            for (_, of) in COLUMNS {
                let values: Vec<f64> = metrics.iter().filter_map(of).collect();
                let interval = mean_interval(&values).context("fewer than two trials")?;
                let cell = format!("{:.3} +- {:.3}", interval.value, interval.high - interval.value);
                line += &format!(" {cell:>20}");
            }
            say(&line);
        }
    }
    Ok(())
}
