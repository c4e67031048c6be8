//! Whether the target stays in the picture: how often it leaves it, for how long, and where trials end.

use std::path::Path;

use anyhow::Result;
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::measure;

use super::Options;
use super::recorded::{read, region, scenario, simulated_from};
use crate::say;

/// Prints the table.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    say(&format!(
        "\n{:34} {:>7} {:>16} {:>10} {:>16} {:>14}",
        "the target and the picture", "trials", "at its border", "left it", "s out per trial", "end outside"
    ));
    for arena in [1, 2] {
        let scenario = scenario(arena, options.scenarios.as_deref())?;
        for (name, with_lost) in [("recorded, all", true), ("recorded, target never lost", false)] {
            let logs: Vec<TrialLog> =
                read(folder, arena, with_lost)?.into_iter().map(|trial| trial.log).collect();
            row(&format!("arena {arena}, {name}"), &logs);
        }
        let logs = simulated_from(&scenario, options.first_seed, options.seeds)?;
        row(&format!("arena {arena}, simulated"), &logs);
    }
    Ok(())
}

fn row(name: &str, logs: &[TrialLog]) {
    let count = logs.len();
    let metrics: Vec<_> = logs.iter().map(|log| measure(log, region(log), log.picture)).collect();
    let share = |number: usize| format!("{number} ({:.0} %)", 100.0 * number as f64 / count as f64);
    let truths: Option<Vec<_>> = logs.iter().map(|log| log.truth.as_ref()).collect();
    // A recorded place at the border is all that tells of a target that left the picture.
    let left = truths.map_or_else(
        || "?".to_owned(),
        |truths| share(truths.iter().filter(|truth| truth.iter().any(|row| row.out_of_picture)).count()),
    );
    let out_s: Option<f64> = metrics.iter().map(|m| m.out_of_picture_s).sum();
    say(&format!(
        "{name:34} {count:>7} {:>16} {left:>10} {:>16} {:>14}",
        share(metrics.iter().filter(|m| m.border_s > 0.0).count()),
        out_s.map_or_else(|| "?".to_owned(), |s| format!("{:.2}", s / count as f64)),
        share(metrics.iter().filter(|m| m.ends_outside).count()),
    ));
}
