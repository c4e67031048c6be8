//! The table of metrics that `trials`, `merge` and `metrics` print.

use std::fmt::Write as _;
use std::io::{Write as _, stdout};

use anyhow::Result;
use barrelman_trial::metrics::{Arena, Summary};

/// Prints the table of the main metrics, or all metrics as JSON.
///
/// # Errors
/// If the output cannot be written.
pub(super) fn print(summary: &Summary, as_json: bool) -> Result<()> {
    let text = if as_json { serde_json::to_string_pretty(summary)? + "\n" } else { format(summary)? };
    Ok(stdout().write_all(text.as_bytes())?)
}

/// The table of the main metrics.
///
/// # Errors
/// Never in practice: the table is written into a string.
fn format(summary: &Summary) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let width = summary.trials.iter().map(|trial| trial.name.len()).max().unwrap_or(0).max("trial".len());
    writeln!(
        text,
        "{:width$}  {:>7}  {:>10}  {:>9}  {:>6}  {:>7}  {:>6}  {:>6}  {:>5}  {:>9}  {:>7}",
        "trial",
        "time s",
        "excursions",
        "outside s",
        "max P",
        "mean b",
        "mean h",
        "moves",
        "rad",
        "rad2/s",
        "s"
    )?;
    for trial in &summary.trials {
        let m = &trial.metrics;
        writeln!(
            text,
            "{:width$}  {:>7.1}  {:>10}  {:>9.2}  {:>6}  {:>7}  {:>6}  {:>6}  {:>5}  {:>9}  {:>7}{}",
            trial.name,
            m.duration_s,
            format!("{}/{}", m.complete_excursions, m.excursions),
            m.time_outside_s,
            number(m.max_p, 2),
            number(m.mean_b_s, 2),
            number(m.mean_h, 2),
            m.moves.map_or_else(|| "-".to_owned(), |moves| moves.to_string()),
            number(m.travel_rad, 2),
            number(m.effort_rad2_per_s, 3),
            number(m.sensitivity, 3),
            if m.ends_outside { "  ends outside" } else { "" },
        )?;
    }
    write_perception(&mut text, summary, width)?;
    for (number_of_arena, figures) in &summary.arenas {
        let outside: usize = summary
            .trials
            .iter()
            .filter(|trial| trial.arena.is_some_and(|arena| arena.number().to_string() == *number_of_arena))
            .filter(|trial| trial.metrics.ends_outside)
            .count();
        let published =
            number_of_arena.parse().ok().and_then(Arena::from_number).map(Arena::published_sensitivity);
        writeln!(
            text,
            "\narena {number_of_arena}: {} trials, mean sensitivity {} (published {}), normalised {}, success rate {} \
             ({outside} end outside; the paper claims 1.00)",
            figures.trials,
            number(figures.pooled.mean_sensitivity, 4),
            number(published, 4),
            number(figures.pooled.normalised_sensitivity, 4),
            number(figures.pooled.success_rate, 2),
        )?;
    }
    if summary.arenas.is_empty() {
        writeln!(
            text,
            "\nall: mean sensitivity {}, normalised {}, success rate {}",
            number(summary.pooled.mean_sensitivity, 4),
            number(summary.pooled.normalised_sensitivity, 4),
            number(summary.pooled.success_rate, 2),
        )?;
    }
    Ok(text)
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

/// A second table for trials in pixels: what the tracker said, beside the truth.
fn write_perception(text: &mut String, summary: &Summary, width: usize) -> std::fmt::Result {
    let mut trials = summary.trials.iter().filter(|trial| trial.metrics.is_in_pixels()).peekable();
    if trials.peek().is_none() {
        return Ok(());
    }
    writeln!(
        text,
        "\n{:width$}  {:>9}  {:>7}  {:>13}  {:>7}  {:>7}  {:>10}  result",
        "trial", "tracked %", "blind s", "sure, wrong %", "first s", "again s", "selections"
    )?;
    for trial in trials {
        let (m, p) = (&trial.metrics, &trial.metrics.perception);
        let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
        writeln!(
            text,
            "{:width$}  {:>9}  {:>7}  {:>13}  {:>7}  {:>7}  {:>10}  {}",
            trial.name,
            number(percent(p.tracked), 1),
            number(p.blind_s, 2),
            number(percent(p.sure_wrong), 1),
            number(p.first_track_s, 2),
            number(p.reacquire_s, 2),
            p.selections.unwrap_or(0),
            match (m.is_success(), m.lost) {
                (true, _) => "success",
                (false, Some(true)) => "out of the picture",
                (false, _) => "not tracked",
            },
        )?;
    }
    Ok(())
}
