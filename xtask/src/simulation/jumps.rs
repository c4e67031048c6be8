//! How the published sensitivities come about: the jumps of the authors' tracker, laid over simulated trials.
//!
//! In nearly every recorded trial the tracked place leaps away once and comes back within a second, as if a hand in
//! the picture had drawn the tracker to itself. Such a *spike* is a run of steps of more than [`JUMP_PX`] that follow
//! each other within [`SPIKE_S`] and end near where they began. Here the spikes of the recorded trials are measured:
//! when they come, and by how much each row is off the straight line between the row before and the row after. A
//! simulated trial is then given the spikes of one recorded trial that is drawn for it, after the fact: its camera
//! knows nothing of them. What the sensitivity becomes shows what the spikes are worth; what makes boat and camera move
//! stays as it is.

use std::path::Path;

use anyhow::{Context, Result};
use barrelman_sim::noise;
use barrelman_trial::campaign::statistics::mean_interval;
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::{Arena, find_excursions, measure};
use barrelman_vocab::ImagePoint;

use super::Options;
use super::recorded::{JUMP_PX, figures, read, region, scenario, simulated_from, step_px};
use crate::say;

/// Steps that follow each other within this belong to one spike, seconds.
const SPIKE_S: f64 = 1.0;
/// It ends within so many pixels of where it began, for each second that it lasts and one more.
const BACK_PX: f64 = 60.0;
/// What the tracker's places are clamped to, pixels.
const BORDER_PX: (f64, f64) = (317.0, 178.0);

/// The place leaps away and comes back.
#[derive(Debug, Clone)]
struct Spike {
    /// From the start of the trial, seconds.
    at_s: f64,
    /// By how much each of its rows is off, pixels, and when, from its start.
    off: Vec<(f64, (f64, f64))>,
}

impl Spike {
    fn duration_s(&self) -> f64 {
        self.off.last().map_or(0.0, |(at_s, _)| *at_s)
    }

    fn largest_px(&self) -> f64 {
        self.off.iter().map(|(_, (x, y))| x.hypot(*y)).fold(0.0, f64::max)
    }
}

/// The spikes of a trial.
fn spikes(log: &TrialLog) -> Vec<Spike> {
    let jumps: Vec<usize> = (1..log.rows.len()).filter(|row| step_px(log, *row) > JUMP_PX).collect();
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for jump in jumps {
        match runs.last_mut() {
            Some((_, last)) if log.rows[jump].time_s - log.rows[*last].time_s <= SPIKE_S => *last = jump,
            _ => runs.push((jump, jump)),
        }
    }
    runs.into_iter().filter_map(|(first, last)| spike(log, first, last)).collect()
}

/// What the rows from one jump to another are, where the place was back after the last one.
fn spike(log: &TrialLog, first: usize, last: usize) -> Option<Spike> {
    let start_s = log.rows.first()?.time_s;
    let (before, after) = (log.rows[first - 1], log.rows[last]);
    let (from, to) = (before.position?, after.position?);
    let took_s = after.time_s - before.time_s;
    if first == last || (to.x - from.x).hypot(to.y - from.y) > BACK_PX * (1.0 + took_s) {
        return None;
    }
    let off = log.rows[first..last].iter().filter_map(|row| {
        let at = row.position?;
        let share = (row.time_s - before.time_s) / took_s;
        let off = (at.x - from.x - share * (to.x - from.x), at.y - from.y - share * (to.y - from.y));
        Some((row.time_s - before.time_s, off))
    });
    Some(Spike { at_s: before.time_s - start_s, off: off.collect() })
}

/// The same trial as a tracker that leapt would have logged it.
fn with_spikes(log: &TrialLog, spikes: &[Spike]) -> TrialLog {
    let mut log = log.clone();
    let start_s = log.rows.first().map_or(0.0, |row| row.time_s);
    for row in &mut log.rows {
        let Some(at) = row.position else { continue };
        for spike in spikes {
            let since_s = row.time_s - start_s - spike.at_s;
            // The row of the spike that was logged last.
            let logged = spike.off.partition_point(|(at_s, _)| *at_s <= since_s);
            if logged == 0
                || since_s > spike.duration_s() + 1.0 / barrelman_trial::logs::laboratory::ROWS_PER_SECOND
            {
                continue;
            }
            let (x, y) = spike.off[logged - 1].1;
            row.position = Some(ImagePoint {
                x: (at.x + x).round().clamp(-BORDER_PX.0, BORDER_PX.0),
                y: (at.y + y).round().clamp(-BORDER_PX.1, BORDER_PX.1),
            });
        }
    }
    log
}

fn sensitivity(log: &TrialLog) -> Option<f64> {
    measure(log, region(log), log.picture).sensitivity
}

fn interval(values: &[f64]) -> Result<String> {
    let interval = mean_interval(values).context("fewer than two trials")?;
    Ok(format!("{:.3} +- {:.3}", interval.value, interval.high - interval.value))
}

/// Excursions, and those in which the place jumped.
fn jumped(logs: &[TrialLog]) -> String {
    let all: usize = logs.iter().map(|log| find_excursions(log, region(log)).len()).sum();
    let jumped: usize = logs.iter().map(|log| figures(log).excursions_with_jumps).sum();
    format!("{jumped} of {all} ({:.1} %)", 100.0 * jumped as f64 / all.max(1) as f64)
}

/// Prints the tables.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    for number in [1, 2] {
        let scenario = scenario(number, options.scenarios.as_deref())?;
        let arena = Arena::from_number(number).context("an arena of the paper")?;
        let logs = |with_lost| -> Result<Vec<TrialLog>> {
            Ok(read(folder, number, with_lost)?.into_iter().map(|trial| trial.log).collect())
        };
        let (all, kept) = (logs(true)?, logs(false)?);
        let of_trials: Vec<Vec<Spike>> = all.iter().map(spikes).collect();
        let every: Vec<&Spike> = of_trials.iter().flatten().collect();
        let column = |of: fn(&Spike) -> f64| {
            let mut values: Vec<f64> = every.iter().map(|spike| of(spike)).collect();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| values.get((share * values.len() as f64) as usize).copied().unwrap_or(0.0);
            format!("{:.2} ({:.2} to {:.2})", at(0.5), at(0.0), at(0.999))
        };
        say(&format!(
            "\narena {number}: {} spikes in {} recorded trials; median and range: {} s after the start, {} s long, {} px \
             at most",
            every.len(),
            all.len(),
            column(|spike| spike.at_s),
            column(Spike::duration_s),
            column(Spike::largest_px),
        ));
        let simulated = simulated_from(&scenario, options.first_seed, options.seeds)?;
        let leapt: Vec<TrialLog> = simulated
            .iter()
            .zip(0..)
            .map(|(log, index)| {
                let drawn = (noise::unit(9, u64::from(number), index) * of_trials.len() as f64) as usize;
                with_spikes(log, &of_trials[drawn.min(of_trials.len() - 1)])
            })
            .collect();
        say(&format!("{:46} {:>18} {:>24}", "sensitivity, 1/s", "mean of trials", "excursions with jumps"));
        say(&format!("{:46} {:>18.4}", "published", arena.published_sensitivity()));
        let row = |name: &str, logs: &[TrialLog], of: fn(&TrialLog) -> Option<f64>| -> Result<()> {
            let values: Vec<f64> = logs.iter().filter_map(of).collect();
            say(&format!("{name:46} {:>18} {:>24}", interval(&values)?, jumped(logs)));
            Ok(())
        };
        row("recorded, all trials and excursions", &all, sensitivity)?;
        row("recorded, target never lost", &kept, sensitivity)?;
        row("recorded, and without excursions with jumps", &kept, |log| figures(log).values[5])?;
        row("simulated", &simulated, sensitivity)?;
        row("simulated, with the recorded spikes", &leapt, sensitivity)?;
        row("simulated, and without excursions with jumps", &leapt, |log| figures(log).values[5])?;
    }
    Ok(())
}
