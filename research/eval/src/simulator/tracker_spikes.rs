//! The table `jumps`: how the published sensitivities arise from the jumps of the authors' tracker.
//!
//! In nearly every recorded trial the tracked position jumps away once and returns within a second, probably
//! because a hand in the picture attracted the tracker. A *spike* is a run of jumps that follow each other
//! within [`SPIKE_GAP_S`] and end near where they began. The spikes of the recorded trials are measured: when
//! they occur, and the offset of each row from the straight line between the row before the spike and the row
//! after it. Each simulated trial then gets the spikes of one recorded trial, chosen at random, after the
//! simulation: the simulated camera does not react to them. The change of the sensitivity shows the effect of
//! the spikes alone; boat and camera move as before. Nothing is judged.

use std::path::Path;

use anyhow::{Context, Result};
use barrelman_sim::noise;
use barrelman_trial::logs::{TrialLog, laboratory::ROWS_PER_SECOND};
use barrelman_trial::metrics::{Arena, find_excursions};
use barrelman_vocab::ImagePoint;

use super::excursion_summary::ExcursionSummary;
use super::laboratory::{load_scenario, measure_trial, read_recorded, region, simulate_all};
use super::options::Options;
use super::position_jump::is_jump;
use crate::output::print_line;
use crate::statistics::mean_with_interval;

/// Jumps that follow each other within this time belong to one spike, seconds.
const SPIKE_GAP_S: f64 = 1.0;
/// Largest distance from a spike's start to its end, pixels per second of its duration plus one second.
const MAX_RETURN_PX_PER_S: f64 = 60.0;
/// The largest |x| and |y| that the tracker reports, pixels.
const BORDER_PX: (f64, f64) = (317.0, 178.0);
/// Stream of the random choice of a recorded trial.
const STREAM: u64 = 9;

/// The position jumps away and returns.
#[derive(Debug, Clone)]
struct Spike {
    /// From the start of the trial, seconds.
    start_s: f64,
    /// Its rows.
    rows: Vec<SpikeRow>,
}

/// One row of a spike.
#[derive(Debug, Clone, Copy)]
struct SpikeRow {
    /// From the start of the spike, seconds.
    since_start_s: f64,
    /// Offset of the position, pixels.
    offset_px: (f64, f64),
}

impl Spike {
    fn duration_s(&self) -> f64 {
        self.rows.last().map_or(0.0, |row| row.since_start_s)
    }

    fn max_offset_px(&self) -> f64 {
        self.rows.iter().map(|row| row.offset_px.0.hypot(row.offset_px.1)).fold(0.0, f64::max)
    }

    /// The spike from one jump to another; `None` where the position did not return.
    fn between_jumps(log: &TrialLog, first: usize, last: usize) -> Option<Self> {
        let trial_start_s = log.rows.first()?.time_s;
        let (before, after) = (log.rows[first - 1], log.rows[last]);
        let (from, to) = (before.position?, after.position?);
        let duration_s = after.time_s - before.time_s;
        let max_return_px = MAX_RETURN_PX_PER_S * (1.0 + duration_s);
        if first == last || (to.x - from.x).hypot(to.y - from.y) > max_return_px {
            return None;
        }
        let rows = log.rows[first..last].iter().filter_map(|row| {
            let at = row.position?;
            let since_start_s = row.time_s - before.time_s;
            let share = since_start_s / duration_s;
            let offset_px =
                (at.x - from.x - share * (to.x - from.x), at.y - from.y - share * (to.y - from.y));
            Some(SpikeRow { since_start_s, offset_px })
        });
        Some(Self { start_s: before.time_s - trial_start_s, rows: rows.collect() })
    }
}

/// The spikes of a trial.
fn find_spikes(log: &TrialLog) -> Vec<Spike> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for jump in (1..log.rows.len()).filter(|row| is_jump(log, *row)) {
        match runs.last_mut() {
            Some((_, last)) if log.rows[jump].time_s - log.rows[*last].time_s <= SPIKE_GAP_S => *last = jump,
            _ => runs.push((jump, jump)),
        }
    }
    runs.into_iter().filter_map(|(first, last)| Spike::between_jumps(log, first, last)).collect()
}

/// A copy of a trial with spikes added to the positions.
fn with_spikes(log: &TrialLog, spikes: &[Spike]) -> TrialLog {
    let mut log = log.clone();
    let start_s = log.rows.first().map_or(0.0, |row| row.time_s);
    for row in &mut log.rows {
        let Some(at) = row.position else { continue };
        for spike in spikes {
            let since_s = row.time_s - start_s - spike.start_s;
            // The spike's row that was logged last.
            let logged = spike.rows.partition_point(|row| row.since_start_s <= since_s);
            if logged == 0 || since_s > spike.duration_s() + 1.0 / ROWS_PER_SECOND {
                continue;
            }
            let (x, y) = spike.rows[logged - 1].offset_px;
            row.position = Some(ImagePoint {
                x: (at.x + x).round().clamp(-BORDER_PX.0, BORDER_PX.0),
                y: (at.y + y).round().clamp(-BORDER_PX.1, BORDER_PX.1),
            });
        }
    }
    log
}

/// Prints the tables.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    for number in [1, 2] {
        let scenario = load_scenario(number, options.scenarios.as_deref())?;
        let arena = Arena::from_number(number).context("an arena of the paper")?;
        let (all, never_lost) = (read_recorded(folder, number, true)?, read_recorded(folder, number, false)?);
        let spikes_of_trials: Vec<Vec<Spike>> = all.iter().map(find_spikes).collect();
        print_spikes(number, &spikes_of_trials);
        let simulated = simulate_all(&scenario, options.seed_range())?;
        let with_spikes: Vec<TrialLog> = simulated
            .iter()
            .zip(0..)
            .map(|(log, index)| {
                let chosen =
                    (noise::unit(STREAM, u64::from(number), index) * spikes_of_trials.len() as f64) as usize;
                with_spikes(log, &spikes_of_trials[chosen.min(spikes_of_trials.len() - 1)])
            })
            .collect();
        print_line(&format!(
            "{:46} {:>18} {:>24}",
            "sensitivity, 1/s", "mean of trials", "excursions with jumps"
        ));
        print_line(&format!("{:46} {:>18.4}", "published", arena.published_sensitivity()));
        let with_jumps = |log: &TrialLog| measure_trial(log).sensitivity;
        let without_jumps = |log: &TrialLog| ExcursionSummary::from_log(log).sensitivity;
        print_sensitivity("recorded, all trials and excursions", &all, with_jumps)?;
        print_sensitivity("recorded, target never lost", &never_lost, with_jumps)?;
        print_sensitivity("recorded, and without excursions with jumps", &never_lost, without_jumps)?;
        print_sensitivity("simulated", &simulated, with_jumps)?;
        print_sensitivity("simulated, with the recorded spikes", &with_spikes, with_jumps)?;
        print_sensitivity("simulated, and without excursions with jumps", &with_spikes, without_jumps)?;
    }
    Ok(())
}

/// Prints how many spikes an arena's trials have, and median and range of their start, duration and offset.
fn print_spikes(arena: u8, spikes_of_trials: &[Vec<Spike>]) {
    let spikes: Vec<&Spike> = spikes_of_trials.iter().flatten().collect();
    let median_and_range = |value: fn(&Spike) -> f64| {
        let mut values: Vec<f64> = spikes.iter().map(|spike| value(spike)).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values.get((share * values.len() as f64) as usize).copied().unwrap_or(0.0);
        format!("{:.2} ({:.2} to {:.2})", at(0.5), at(0.0), at(0.999))
    };
    print_line(&format!(
        "\narena {arena}: {} spikes in {} recorded trials; median and range: {} s after the start, {} s long, {} px \
         at most",
        spikes.len(),
        spikes_of_trials.len(),
        median_and_range(|spike| spike.start_s),
        median_and_range(Spike::duration_s),
        median_and_range(Spike::max_offset_px),
    ));
}

/// Prints a row: the mean sensitivity, and the excursions with a jump.
fn print_sensitivity(
    name: &str,
    logs: &[TrialLog],
    sensitivity: impl Fn(&TrialLog) -> Option<f64>,
) -> Result<()> {
    let values: Vec<f64> = logs.iter().filter_map(sensitivity).collect();
    let all: usize = logs.iter().map(|log| find_excursions(log, region(log)).len()).sum();
    let with_jumps: usize =
        logs.iter().map(|log| ExcursionSummary::from_log(log).excursions_with_jumps).sum();
    let share = format!("{with_jumps} of {all} ({:.1} %)", 100.0 * with_jumps as f64 / all.max(1) as f64);
    print_line(&format!("{name:46} {:>18} {share:>24}", mean_with_interval(&values)?));
    Ok(())
}
