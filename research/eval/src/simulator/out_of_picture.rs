//! The table `picture`: in how many trials the target reaches the picture's border or leaves the picture, for
//! how long, and how many trials end with the target outside the region.

use std::path::Path;

use anyhow::Result;
use barrelman_trial::logs::TrialLog;

use super::laboratory::{load_scenario, measure_trial, read_recorded, simulate_all};
use super::options::Options;
use crate::output::print_line;

/// Prints the table.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    print_line(&format!(
        "\n{:34} {:>7} {:>16} {:>10} {:>16} {:>14}",
        "the target and the picture", "trials", "at its border", "left it", "s out per trial", "end outside"
    ));
    for arena in [1, 2] {
        let scenario = load_scenario(arena, options.scenarios.as_deref())?;
        for (name, include_lost) in [("recorded, all", true), ("recorded, target never lost", false)] {
            let logs = read_recorded(folder, arena, include_lost)?;
            print_row(&format!("arena {arena}, {name}"), &logs);
        }
        let logs = simulate_all(&scenario, options.seed_range())?;
        print_row(&format!("arena {arena}, simulated"), &logs);
    }
    Ok(())
}

fn print_row(name: &str, logs: &[TrialLog]) {
    let trials = logs.len();
    let metrics: Vec<_> = logs.iter().map(measure_trial).collect();
    let share = |count: usize| format!("{count} ({:.0} %)", 100.0 * count as f64 / trials as f64);
    // Recorded positions are clamped to the border, so that only the truth of a simulated trial tells whether
    // the target left the picture.
    let truths: Option<Vec<_>> = logs.iter().map(|log| log.truth.as_ref()).collect();
    let left = truths.map_or_else(
        || "?".to_owned(),
        |truths| share(truths.iter().filter(|truth| truth.iter().any(|row| row.out_of_picture)).count()),
    );
    let out_s: Option<f64> = metrics.iter().map(|m| m.out_of_picture_s).sum();
    print_line(&format!(
        "{name:34} {trials:>7} {:>16} {left:>10} {:>16} {:>14}",
        share(metrics.iter().filter(|m| m.border_s > 0.0).count()),
        out_s.map_or_else(|| "?".to_owned(), |s| format!("{:.2}", s / trials as f64)),
        share(metrics.iter().filter(|m| m.ends_outside).count()),
    ));
}
