//! The table of metrics that `trials`, `merge` and `metrics` print, 80 columns wide where the names are
//! short.

use std::fmt::Write as _;
use std::io::{Write as _, stdout};

use anyhow::Result;
use barrelman_trial::metrics::{Arena, PUBLISHED_NORMALISED_SENSITIVITY, Summary, TrialEntry};

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
    write_trials(&mut text, summary, width)?;
    write_perception(&mut text, summary, width)?;
    write_guidance(&mut text, summary, width)?;
    for number_of_arena in summary.arenas.keys() {
        let Some(arena) = number_of_arena.parse().ok().and_then(Arena::from_number) else { continue };
        let trials: Vec<&TrialEntry> =
            summary.trials.iter().filter(|trial| trial.arena == Some(arena)).collect();
        write_pooled(&mut text, Some(arena), &trials, summary)?;
    }
    if summary.arenas.is_empty() {
        write_pooled(&mut text, None, &summary.trials.iter().collect::<Vec<_>>(), summary)?;
    }
    Ok(text)
}

/// A row for each trial.
fn write_trials(text: &mut String, summary: &Summary, width: usize) -> std::fmt::Result {
    let mut row = |cells: [&str; 12]| {
        let [name, time, excursions, out, max_p, h, b, moves, switches, travel, effort, s] = cells;
        let line = format!(
            "{name:width$} {time:>5} {excursions:>5} {out:>6} {max_p:>5} {h:>4} {b:>4} {moves:>5} {switches:>8} \
             {travel:>6} {effort:>6} {s:>5}"
        );
        writeln!(text, "{}", line.trim_end())
    };
    row(["trial", "time", "exc.", "out", "max P", "h", "b", "moves", "switches", "travel", "effort", "s"])?;
    row(["", "s", "", "s", "", "", "s", "", "", "rad", "rad2/s", "1/s"])?;
    for trial in &summary.trials {
        let m = &trial.metrics;
        let count = |value: Option<usize>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
        row([
            &trial.name,
            &format!("{:.1}", m.duration_s),
            &format!("{}/{}", m.complete_excursions, m.excursions),
            &format!("{:.1}{}", m.time_outside_s, if m.ends_outside { "*" } else { " " }),
            &number(m.max_p, 2),
            &number(m.mean_h, 2),
            &number(m.mean_b_s, 2),
            &count(m.moves),
            &count(m.switches),
            &number(m.travel_rad, 2),
            &number(m.effort_rad2_per_s, 3),
            &number(m.sensitivity, 3),
        ])?;
    }
    Ok(())
}

/// The figures of an arena beside the published ones, or of all trials, a line each.
fn write_pooled(
    text: &mut String,
    arena: Option<Arena>,
    trials: &[&TrialEntry],
    summary: &Summary,
) -> std::fmt::Result {
    let pooled = arena
        .and_then(|arena| summary.arenas.get(&arena.number().to_string()))
        .map_or(&summary.pooled, |arena| &arena.pooled);
    let all = trials.len();
    let count =
        |condition: &dyn Fn(&TrialEntry) -> bool| trials.iter().filter(|trial| condition(trial)).count();
    let title = arena.map_or_else(|| "all".to_owned(), |arena| format!("arena {}", arena.number()));
    let mut line = |name: &str, value: &str, published: &str| {
        let published = if arena.is_some() { published } else { "" };
        writeln!(text, "{}", format!("{name:46} {value:>10}  {published:>12}").trim_end())
    };
    line("", "", "")?;
    line(&format!("{title}, {}", count_of(all)), "here", "published")?;
    let with_s = count(&|trial| trial.metrics.sensitivity.is_some());
    let of = if with_s < all { format!(", of the {with_s} with an s") } else { String::new() };
    line(
        &format!("  mean sensitivity, 1/s{of}"),
        &number(pooled.mean_sensitivity, 4),
        &number(arena.map(Arena::published_sensitivity), 4),
    )?;
    let n =
        arena.map_or("the mean excursion count".to_owned(), |arena| format!("n = {}", arena.published_n()));
    line(
        &format!("  normalised by {n}, 1/s"),
        &number(pooled.normalised_sensitivity, 4),
        PUBLISHED_NORMALISED_SENSITIVITY,
    )?;
    line("  succeeded", &format!("{} of {all}", count(&|trial| trial.metrics.is_success())), "all, claimed")?;
    line(
        "  end outside the ellipse",
        &format!("{} of {all}", count(&|trial| trial.metrics.ends_outside)),
        "",
    )?;
    write_rules(text, arena, trials)
}

/// What counts as a success, and what the published figure rests on.
fn write_rules(text: &mut String, arena: Option<Arena>, trials: &[&TrialEntry]) -> std::fmt::Result {
    let any = |condition: &dyn Fn(&TrialEntry) -> bool| trials.iter().any(|trial| condition(trial));
    if any(&|trial| trial.metrics.lost.is_some()) {
        writeln!(
            text,
            "Succeeded: the boat was never out of the picture for over 2 s, nor at the end. A\n\
             boat outside the ellipse is still in the picture."
        )?;
    }
    if any(&|trial| trial.metrics.is_in_pixels()) {
        writeln!(
            text,
            "In pixels also: tracked for 95 % of the time in which it was visible, and never\n\
             for over 5 s not."
        )?;
    }
    if any(&|trial| trial.metrics.lost.is_none()) {
        writeln!(
            text,
            "A log that does not tell whether the boat was in the picture succeeds where it\n\
             does not end outside the ellipse."
        )?;
    }
    if arena.is_some() && any(&|trial| trial.metrics.lost.is_some()) {
        writeln!(
            text,
            "The published sensitivity contains jumps of the paper's tracker, which make\n\
             about half of it: it is no measure for these trials (docs/simulation.md, \"How\n\
             the published sensitivities come about\")."
        )?;
    }
    Ok(())
}

pub(super) fn count_of(trials: usize) -> String {
    format!("{trials} trial{}", if trials == 1 { "" } else { "s" })
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

/// A table for trials with guidance: how the boat went to the person.
fn write_guidance(text: &mut String, summary: &Summary, width: usize) -> std::fmt::Result {
    let guided = |trial: &TrialEntry| trial.metrics.guidance.map(|guidance| (trial.name.clone(), guidance));
    let mut trials = summary.trials.iter().filter_map(guided).peekable();
    if trials.peek().is_none() {
        return Ok(());
    }
    let mut row = |cells: [&str; 8]| {
        let [name, arrived, time, off, rudder, closest, path, view] = cells;
        let line = format!(
            "{name:width$} {arrived:>8} {time:>7} {off:>8} {rudder:>7} {closest:>8} {path:>6} {view:>8}"
        );
        writeln!(text, "{}", line.trim_end())
    };
    row([""; 8])?;
    row(["trial", "arrived", "time", "off line", "rudder", "closest", "path", "in view"])?;
    row(["", "", "s", "m", "", "m", "", "%"])?;
    for (name, guidance) in trials {
        row([
            &name,
            if guidance.arrived { "yes" } else { "no" },
            &number(guidance.time_to_circle_s, 1),
            &number(guidance.cross_track_m, 2),
            &number(guidance.rudder_travel, 1),
            &number(guidance.closest_person_m, 1),
            &number(guidance.path_ratio, 2),
            &number(guidance.both_in_view.map(|share| 100.0 * share), 1),
        ])?;
    }
    Ok(())
}

/// A second table for trials in pixels: what the tracker said, beside the truth.
fn write_perception(text: &mut String, summary: &Summary, width: usize) -> std::fmt::Result {
    let mut trials = summary.trials.iter().filter(|trial| trial.metrics.is_in_pixels()).peekable();
    if trials.peek().is_none() {
        return Ok(());
    }
    let mut row = |cells: [&str; 8]| {
        let [name, tracked, blind, wrong, first, again, selections, result] = cells;
        let line = format!(
            "{name:width$} {tracked:>9} {blind:>7} {wrong:>7} {first:>7} {again:>7} {selections:>6}  {result}"
        );
        writeln!(text, "{}", line.trim_end())
    };
    row([""; 8])?;
    row(["trial", "tracked", "blind", "wrong", "first", "again", "sel.", "result"])?;
    row(["", "%", "s", "%", "s", "s", "", ""])?;
    for trial in trials {
        let (m, p) = (&trial.metrics, &trial.metrics.perception);
        let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
        row([
            &trial.name,
            &number(percent(p.tracked), 1),
            &number(p.blind_s, 2),
            &number(percent(p.sure_wrong), 1),
            &number(p.first_track_s, 2),
            &number(p.reacquire_s, 2),
            &p.selections.unwrap_or(0).to_string(),
            match (m.is_success(), m.lost) {
                (true, _) => "success",
                (false, Some(true)) => "out of the picture",
                (false, _) => "not tracked",
            },
        ])?;
    }
    Ok(())
}
