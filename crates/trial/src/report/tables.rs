//! Tables of the page: the figures of each arena beside the published ones, and the list of all trials.

use super::sets::{Group, SetKind};
use super::text::{escaped, number, optional};
use super::{ReportedTrial, sparkline};
use crate::campaign::statistics::mean_interval;
use crate::metrics::{Arena, TrialMetrics};

/// The normalised sensitivity as published, of both arenas.
const PUBLISHED_NORMALISED: &str = "0.034";

/// A mean over trials: what it is called, its unit, its decimals, and where a trial has it.
type Mean = (&'static str, &'static str, usize, fn(&TrialMetrics) -> Option<f64>);

const MEANS: [Mean; 8] = [
    ("Excursions", "a trial", 1, |m| Some(m.excursions as f64)),
    ("Time outside", "s a trial", 1, |m| Some(m.time_outside_s)),
    ("Length", "s a trial", 1, |m| Some(m.duration_s)),
    ("h, largest P less 1", "mean", 2, |m| m.mean_h),
    ("b, time outside", "s, mean", 2, |m| m.mean_b_s),
    ("Integral of |rate|", "rad a trial", 2, |m| m.travel_rad),
    ("Moves", "starts a trial", 1, |m| m.moves.map(|moves| moves as f64)),
    ("Share of time moving", "%", 0, |m| m.duty.map(|duty| 100.0 * duty)),
];

/// The figures of one arena, sets side by side.
pub(super) fn of_arena(arena: Option<Arena>, groups: &[Group<'_>]) -> String {
    let mut rows: Vec<(String, &str, Vec<String>)> = Vec::new();
    let mut row =
        |name: &str, unit: &'static str, published: Option<String>, of: &dyn Fn(&Group<'_>) -> String| {
            let mut cells = Vec::new();
            if arena.is_some() {
                cells.push(published.unwrap_or_else(|| "\u{2013}".to_owned()));
            }
            cells.extend(groups.iter().map(of));
            rows.push((name.to_owned(), unit, cells));
        };
    row("Trials", "", None, &|group| group.trials.len().to_string());
    row("Success", "see above", Some("100\u{a0}%<small>claimed</small>".to_owned()), &|group| {
        let (all, good) = (group.trials.len(), group.succeeded());
        format!("{}\u{a0}%<small>{good} of {all}</small>", number(100.0 * good as f64 / all.max(1) as f64, 0))
    });
    row("Ends outside", "trials", None, &|group| {
        group.trials.iter().filter(|trial| trial.entry.metrics.ends_outside).count().to_string()
    });
    let published = arena.map(|arena| format!("<b>{:.4}</b>", arena.published_sensitivity()));
    row("Mean sensitivity", "1/s", published, &|group| {
        let mean = group.summary().pooled.mean_sensitivity;
        let interval = interval(&group.values(|metrics| metrics.sensitivity), 2);
        format!("<b>{}</b>{interval}", optional(mean, 4))
    });
    let published = arena
        .map(|arena| format!("{PUBLISHED_NORMALISED}<small>n = {}</small>", number(arena.published_n(), 0)));
    row("Normalised by n", "1/s", published, &|group| {
        let pooled = group.summary().pooled;
        let n = pooled.mean_sensitivity.zip(pooled.normalised_sensitivity).map(|(mean, by_n)| mean / by_n);
        let n = n
            .filter(|n| n.is_finite())
            .map(|n| format!("<small>n = {}</small>", number(n, usize::from(arena.is_none()))));
        format!("{}{}", optional(pooled.normalised_sensitivity, 4), n.unwrap_or_default())
    });
    for (name, unit, decimals, of) in MEANS {
        row(name, unit, None, &|group| {
            let values = group.values(of);
            let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
            format!("{}{}", optional(mean, decimals), interval(&values, decimals))
        });
    }
    let mut html = String::from("<div class=\"scroll\"><table class=\"figures\"><thead><tr><th></th>");
    if arena.is_some() {
        html += "<th>Published</th>";
    }
    for group in groups {
        html += &format!("<th>{}</th>", escaped(&group.set.name));
    }
    html += "</tr></thead><tbody>";
    for (name, unit, cells) in rows {
        html += &format!("<tr><th scope=\"row\">{} <small>{unit}</small></th>", escaped(&name));
        for (index, cell) in cells.iter().enumerate() {
            let class = if arena.is_some() && index == 0 { " class=\"published\"" } else { "" };
            html += &format!("<td{class}>{cell}</td>");
        }
        html += "</tr>";
    }
    html + "</tbody></table></div>"
}

/// The 95 % interval of a mean, where there is one.
fn interval(values: &[f64], decimals: usize) -> String {
    mean_interval(values).map_or_else(String::new, |interval| {
        format!("<small>{} to {}</small>", number(interval.low, decimals), number(interval.high, decimals))
    })
}

/// All trials, each with a small P over time; `link` says where the figures of a trial are.
pub(super) fn of_trials(trials: &[ReportedTrial]) -> String {
    let mut html = String::from(
        "<div class=\"scroll\"><table class=\"trials\"><thead><tr><th>Trial</th><th>P over time</th><th>Length, s</th>\
         <th>Excursions<small>complete</small></th><th>Outside, s</th><th>Largest P</th><th>\u{222b}|rate|, rad</th>\
         <th>Moves</th><th>s, 1/s</th></tr></thead><tbody>",
    );
    for (index, trial) in trials.iter().enumerate() {
        let m = &trial.entry.metrics;
        let name = escaped(&trial.entry.name);
        let (name, spark) = match &trial.course {
            Some(course) => (
                format!("<a href=\"#t{index}\">{name}</a>"),
                sparkline::figure(&trial.entry.name, course).inline(),
            ),
            None => (name, "<small>metrics only</small>".to_owned()),
        };
        let complete = if m.complete_excursions == m.excursions {
            String::new()
        } else {
            format!("<small>{} complete</small>", m.complete_excursions)
        };
        html += &format!(
            "<tr><th scope=\"row\">{name}{}</th><td class=\"spark\">{spark}</td><td>{}</td><td>{}{complete}</td><td>{}</td>\
             <td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            flags(trial),
            number(m.duration_s, 1),
            m.excursions,
            number(m.time_outside_s, 1),
            optional(m.max_p, 2),
            optional(m.travel_rad, 2),
            m.moves.map_or_else(|| "\u{2013}".to_owned(), |moves| moves.to_string()),
            optional(m.sensitivity, 3),
        );
    }
    html + "</tbody></table></div>"
}

/// What went wrong in a trial.
pub(super) fn flags(trial: &ReportedTrial) -> &'static str {
    let metrics = &trial.entry.metrics;
    match (metrics.lost == Some(true), metrics.ends_outside) {
        (true, _) if trial.set.kind == SetKind::Recorded => "<em>track lost</em>",
        (true, _) => "<em>lost</em>",
        (false, true) => "<em>ends outside</em>",
        (false, false) => "",
    }
}
