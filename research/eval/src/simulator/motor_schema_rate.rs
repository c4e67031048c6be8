//! The table `rate`: what the motor schema's fixed rate does. The paper uses 0.3 rad/s, on which its
//! sensitivities depend.

use anyhow::Result;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_trial::metrics::TrialMetrics;

use super::laboratory::{plan, simulate_and_measure};
use super::options::Options;
use crate::output::print_line;
use crate::statistics::mean_with_interval;

/// Rates, rad/s.
const RATES: [f64; 11] = [0.10, 0.15, 0.20, 0.25, 0.30, 0.35, 0.40, 0.45, 0.50, 0.55, 0.60];

/// A column: its name, and its value for a trial.
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
        print_line(&header);
        for rate in RATES {
            let plan = plan(arena, options.scenarios.as_deref(), LawChoice::MOTOR_SCHEMA, Some(rate))?;
            let metrics = simulate_and_measure(&plan, options.seed_range())?;
            let mut line = format!("{rate:>35.2}");
            for (_, value) in COLUMNS {
                let values: Vec<f64> = metrics.iter().filter_map(value).collect();
                line += &format!(" {:>20}", mean_with_interval(&values)?);
            }
            print_line(&line);
        }
    }
    Ok(())
}
