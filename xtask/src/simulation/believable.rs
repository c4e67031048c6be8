//! Whether simulated laboratory trials are like the recorded ones: the figures of both, with their intervals.

use std::path::Path;

use anyhow::{Context, Result};
use barrelman_trial::campaign::statistics::mean_interval;
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::find_excursions;

use super::recorded::{FIGURES, Recorded, figures, read, region, scenario, simulated_from};
use super::{Options, motion};
use crate::say;

/// Intervals that must have a value in common, of fourteen.
const OVERLAPS: usize = 10;

/// Prints the tables; whether enough intervals overlap.
pub(super) fn run(folder: &Path, options: &Options) -> Result<bool> {
    let (first_seed, seeds) = (options.first_seed, options.seeds);
    let mut overlaps = 0;
    for arena in [1, 2] {
        let scenario = scenario(arena, options.scenarios.as_deref())?;
        let recorded = read(folder, arena, false)?;
        let simulated = simulated_from(&scenario, first_seed, seeds)?;
        say(&format!(
            "\narena {arena}: {} recorded trials without excursions in which the place jumped; {seeds} simulated, seeds \
             from {first_seed} on",
            recorded.len()
        ));
        say(&format!("{:32} {:>22} {:>22}", "mean of the trials, 95 %", "recorded", "simulated"));
        let of_recorded: Vec<_> = recorded.iter().map(|trial| figures(&trial.log)).collect();
        let of_simulated: Vec<_> = simulated.iter().map(figures).collect();
        for (index, name) in FIGURES.iter().enumerate() {
            let column = |all: &[super::recorded::Figures]| {
                let values: Vec<f64> = all.iter().filter_map(|figures| figures.values[index]).collect();
                mean_interval(&values).context("fewer than two trials")
            };
            let (recorded, simulated) = (column(&of_recorded)?, column(&of_simulated)?);
            let overlap = recorded.overlaps(&simulated);
            overlaps += usize::from(overlap);
            let cell = |i: &barrelman_trial::campaign::statistics::Interval| {
                format!("{:.3} +- {:.3}", i.value, i.high - i.value)
            };
            say(&format!(
                "{name:32} {:>22} {:>22}  {}",
                cell(&recorded),
                cell(&simulated),
                if overlap { "overlap" } else { "apart" }
            ));
        }
        axes("recorded", &recorded.iter().map(|t| t.log.clone()).collect::<Vec<_>>());
        axes("simulated", &simulated);
        motion_table(&recorded, &simulated, &scenario)?;
    }
    say(&format!("\n{overlaps} of 14 intervals overlap; at least {OVERLAPS} are asked for"));
    Ok(overlaps >= OVERLAPS)
}

/// By which axis excursions are answered first, per trial, and how long they last.
fn axes(name: &str, logs: &[TrialLog]) {
    let mut by_axis = [(0_usize, 0.0); 2];
    for log in logs {
        for excursion in find_excursions(log, region(log)) {
            let rates = log.rows[excursion.first].rates;
            let axis = usize::from(rates.is_some_and(|rates| rates.yaw.is_zero()));
            by_axis[axis].0 += 1;
            by_axis[axis].1 += excursion.b_s;
        }
    }
    let count = logs.len() as f64;
    let [pan, tilt] =
        by_axis.map(|(n, b)| format!("{:.2} of {:.2} s", n as f64 / count, b / n.max(1) as f64));
    say(&format!("{name}: excursions per trial answered by pan {pan}, by tilt {tilt}"));
}

/// What the target's motion was fitted to.
fn motion_table(
    recorded: &[Recorded],
    simulated: &[TrialLog],
    scenario: &barrelman_sim::Scenario,
) -> Result<()> {
    let of_recorded: Vec<_> = recorded.iter().map(|trial| motion::of(&trial.log, scenario)).collect();
    let of_simulated: Vec<_> = simulated.iter().map(|log| motion::of(log, scenario)).collect();
    say(&format!("{:32} {:>22} {:>22}", "how the target moved", "recorded", "simulated"));
    for (index, name) in motion::STATISTICS.iter().enumerate() {
        let cell = |all: &[motion::Motion]| {
            let values: Vec<f64> = all.iter().map(|motion| motion.values[index]).collect();
            let interval = mean_interval(&values).context("fewer than two trials")?;
            Ok::<_, anyhow::Error>(format!("{:.3} +- {:.3}", interval.value, interval.high - interval.value))
        };
        say(&format!("{name:32} {:>22} {:>22}", cell(&of_recorded)?, cell(&of_simulated)?));
    }
    Ok(())
}
