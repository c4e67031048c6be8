//! The table `believable`: whether simulated trials of the laboratory resemble the recorded ones.
//!
//! For each arena the means over trials of seven metrics are compared, each with its 95 % confidence
//! interval. The requirement: of the fourteen pairs of intervals at least [`MIN_OVERLAPS`] overlap. Below,
//! without a requirement: which axis answers excursions, and the statistics that the target's motion was
//! fitted to.

use std::path::Path;

use anyhow::{Context, Result};
use barrelman_sim::Scenario;
use barrelman_trial::campaign::statistics::{Interval, mean_interval};
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::find_excursions;

use super::excursion_summary::{ExcursionSummary, METRICS};
use super::laboratory::{load_scenario, read_recorded, region, simulate_all};
use super::motion::{MotionStatistics, STATISTICS};
use super::options::Options;
use crate::output::print_line;
use crate::statistics::mean_with_interval;

/// Pairs of intervals, of fourteen, that must overlap.
const MIN_OVERLAPS: usize = 10;

/// Prints the tables. Returns whether enough intervals overlap.
pub(super) fn run(folder: &Path, options: &Options) -> Result<bool> {
    let mut overlaps = 0;
    for arena in [1, 2] {
        let scenario = load_scenario(arena, options.scenarios.as_deref())?;
        let recorded = read_recorded(folder, arena, false)?;
        let simulated = simulate_all(&scenario, options.seed_range())?;
        print_line(&format!(
            "\narena {arena}: {} recorded trials without excursions in which the place jumped; {} simulated, seeds \
             from {} on",
            recorded.len(),
            options.seeds,
            options.first_seed,
        ));
        overlaps += print_metrics(&recorded, &simulated)?;
        print_answering_axes("recorded", &recorded);
        print_answering_axes("simulated", &simulated);
        print_motion(&recorded, &simulated, &scenario)?;
    }
    print_line(&format!("\n{overlaps} of 14 intervals overlap; at least {MIN_OVERLAPS} are asked for"));
    Ok(overlaps >= MIN_OVERLAPS)
}

/// Prints the metrics of both kinds of trials. Returns how many pairs of intervals overlap.
fn print_metrics(recorded: &[TrialLog], simulated: &[TrialLog]) -> Result<usize> {
    print_line(&format!("{:32} {:>22} {:>22}", "mean of the trials, 95 %", "recorded", "simulated"));
    let summarise = |logs: &[TrialLog]| logs.iter().map(ExcursionSummary::from_log).collect::<Vec<_>>();
    let (recorded, simulated) = (summarise(recorded), summarise(simulated));
    let mut overlaps = 0;
    for (name, value) in METRICS {
        let interval = |trials: &[ExcursionSummary]| {
            let values: Vec<f64> = trials.iter().filter_map(value).collect();
            mean_interval(&values).context("fewer than two trials")
        };
        let (recorded, simulated) = (interval(&recorded)?, interval(&simulated)?);
        let is_overlap = recorded.overlaps(&simulated);
        overlaps += usize::from(is_overlap);
        let cell = |i: &Interval| format!("{:.3} +- {:.3}", i.value, i.high - i.value);
        print_line(&format!(
            "{name:32} {:>22} {:>22}  {}",
            cell(&recorded),
            cell(&simulated),
            if is_overlap { "overlap" } else { "apart" }
        ));
    }
    Ok(overlaps)
}

/// Prints for each axis how many excursions per trial it answers first, and their mean duration.
fn print_answering_axes(name: &str, logs: &[TrialLog]) {
    let mut by_axis = [(0_usize, 0.0); 2];
    for log in logs {
        for excursion in find_excursions(log, region(log)) {
            let command = log.rows[excursion.first].command;
            let axis = usize::from(command.is_some_and(|command| command.pan.is_zero()));
            by_axis[axis].0 += 1;
            by_axis[axis].1 += excursion.b_s;
        }
    }
    let trials = logs.len() as f64;
    let [pan, tilt] = by_axis
        .map(|(count, b_s)| format!("{:.2} of {:.2} s", count as f64 / trials, b_s / count.max(1) as f64));
    print_line(&format!("{name}: excursions per trial answered by pan {pan}, by tilt {tilt}"));
}

/// Prints the statistics that the target's motion was fitted to.
fn print_motion(recorded: &[TrialLog], simulated: &[TrialLog], scenario: &Scenario) -> Result<()> {
    let measure = |logs: &[TrialLog]| -> Vec<MotionStatistics> {
        logs.iter().map(|log| MotionStatistics::from_log(log, scenario)).collect()
    };
    let (recorded, simulated) = (measure(recorded), measure(simulated));
    print_line(&format!("{:32} {:>22} {:>22}", "how the target moved", "recorded", "simulated"));
    for (index, statistic) in STATISTICS.iter().enumerate() {
        let cell = |trials: &[MotionStatistics]| {
            mean_with_interval(&trials.iter().map(|trial| trial.values[index]).collect::<Vec<_>>())
        };
        print_line(&format!("{:32} {:>22} {:>22}", statistic.name, cell(&recorded)?, cell(&simulated)?));
    }
    Ok(())
}
