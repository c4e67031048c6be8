//! Tables of the page: the metrics of each arena beside the published ones, and the list of all trials.

use maud::{Markup, PreEscaped, html};

use super::reported_trial::{ReportedTrial, SetKind};
use super::sparkline;
use super::text::{Text, format_number, number_or_dash};
use super::trial_group::TrialGroup;
use crate::campaign::statistics::mean_interval;
use crate::metrics::{Arena, PUBLISHED_NORMALISED_SENSITIVITY, TrialMetrics};

/// A mean over trials: name, unit, decimals, and the value of a trial.
type Mean = (&'static str, &'static str, usize, fn(&TrialMetrics) -> Option<f64>);

const MEANS: [Mean; 10] = [
    ("Excursions", "a trial", 1, |m| Some(m.excursions as f64)),
    ("Time outside", "s a trial", 1, |m| Some(m.time_outside_s)),
    ("Length", "s a trial", 1, |m| Some(m.duration_s)),
    ("h, largest P less 1", "mean", 2, |m| m.mean_h),
    ("b, duration", "s, mean", 2, |m| m.mean_b_s),
    ("\u{222b}|rate|", "rad a trial", 2, |m| m.travel_rad),
    ("\u{222b}rate\u{b2}", "rad\u{b2}/s a trial", 2, |m| m.effort_rad2_per_s),
    ("Moves", "starts a trial", 1, |m| m.moves.map(|moves| moves as f64)),
    ("Switches", "a trial", 1, |m| m.switches.map(|switches| switches as f64)),
    ("Share of time moving", "%", 0, |m| m.duty.map(|duty| 100.0 * duty)),
];

/// Means that trials in pixels alone have.
const MEANS_IN_PIXELS: [Mean; 4] = [
    ("Tracked", "% of the time visible", 1, |m| m.perception.tracked.map(|share| 100.0 * share)),
    ("Longest time not tracked", "s a trial", 1, |m| m.perception.blind_s),
    ("Sure and wrong", "% of the time", 2, |m| m.perception.sure_wrong.map(|share| 100.0 * share)),
    ("Tracked again after", "s", 2, |m| m.perception.reacquire_s),
];

/// Means that trials with guidance alone have.
const MEANS_WITH_GUIDANCE: [Mean; 7] = [
    ("Came to the person", "% of the trials", 0, |m| {
        m.guidance.map(|to| if to.arrived { 100.0 } else { 0.0 })
    }),
    ("Time to 4 m", "s, where it came there", 1, |m| m.guidance.and_then(|to| to.time_to_circle_s)),
    ("Off the line", "m, mean", 2, |m| m.guidance.and_then(|to| to.cross_track_m)),
    ("Path over way", "", 2, |m| m.guidance.and_then(|to| to.path_ratio)),
    ("Rudder travel", "a trial", 1, |m| m.guidance.and_then(|to| to.rudder_travel)),
    ("Closest to any person", "m, mean", 2, |m| m.guidance.and_then(|to| to.closest_person_m)),
    ("Boat and person in view", "% of the time", 1, |m| {
        m.guidance.and_then(|to| to.both_in_view).map(|share| 100.0 * share)
    }),
];

/// The metrics of one arena, sets side by side.
pub(super) fn arena_table(arena: Option<Arena>, groups: &[TrialGroup<'_>]) -> Markup {
    html! {
        div class="scroll" {
            table class="figures" {
                thead {
                    tr {
                        th {}
                        @if arena.is_some() { th { "Published" } }
                        @for group in groups { th { (Text(&group.set.name)) } }
                    }
                }
                tbody {
                    @for row in ArenaRows::new(arena, groups).rows {
                        tr {
                            th scope="row" { (row.name) " " small { (row.unit) } }
                            @if let Some(published) = row.published { td class="published" { (published) } }
                            @for cell in row.cells { td { (cell) } }
                        }
                    }
                }
            }
        }
    }
}

/// A row of an arena's table.
struct ArenaRow {
    name: &'static str,
    unit: &'static str,
    /// The published figure; `None` outside the paper's arenas.
    published: Option<Markup>,
    /// A cell for each group.
    cells: Vec<Markup>,
}

/// The rows of an arena's table.
struct ArenaRows<'a> {
    arena: Option<Arena>,
    groups: &'a [TrialGroup<'a>],
    rows: Vec<ArenaRow>,
}

impl<'a> ArenaRows<'a> {
    fn new(arena: Option<Arena>, groups: &'a [TrialGroup<'a>]) -> Self {
        let mut rows = Self { arena, groups, rows: Vec::new() };
        rows.add_counts();
        rows.add_sensitivities();
        let is_in_pixels =
            |group: &TrialGroup<'_>| group.trials.iter().any(|trial| trial.entry.metrics.is_in_pixels());
        let in_pixels = if groups.iter().any(is_in_pixels) { &MEANS_IN_PIXELS[..] } else { &[] };
        let is_guided =
            |group: &TrialGroup<'_>| group.trials.iter().any(|trial| trial.entry.metrics.guidance.is_some());
        let with_guidance = if groups.iter().any(is_guided) { &MEANS_WITH_GUIDANCE[..] } else { &[] };
        let means = MEANS.iter().chain(in_pixels).chain(with_guidance).copied();
        for (name, unit, decimals, value_of) in means {
            rows.add(name, unit, None, |group| {
                let values = group.values(value_of);
                let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
                html! {
                    (number_or_dash(mean, decimals))
                    (interval(&values, decimals))
                    (count_of_defined(values.len(), group))
                }
            });
        }
        rows
    }

    /// Adds a row; a published figure of `None` is shown as a dash.
    fn add(
        &mut self,
        name: &'static str,
        unit: &'static str,
        published: Option<Markup>,
        cell: impl Fn(&TrialGroup<'_>) -> Markup,
    ) {
        let published = self.arena.map(|_| published.unwrap_or_else(|| html! { "\u{2013}" }));
        self.rows.push(ArenaRow { name, unit, published, cells: self.groups.iter().map(cell).collect() });
    }

    fn add_counts(&mut self) {
        self.add("Trials", "", None, |group| html! { (group.trials.len()) });
        let published = html! { "100\u{a0}%" small { "claimed" } };
        self.add("Success", "see above", Some(published), |group| {
            let (all, good) = (group.trials.len(), group.success_count());
            let percent = format_number(100.0 * good as f64 / all.max(1) as f64, 0);
            html! { (percent) "\u{a0}%" small { (good) " of " (all) } }
        });
        self.add("Ends outside", "trials", None, |group| {
            let outside = group.trials.iter().filter(|trial| trial.entry.metrics.ends_outside);
            html! { (outside.count()) }
        });
    }

    fn add_sensitivities(&mut self) {
        let arena = self.arena;
        let published = arena.map(|arena| html! { b { (format!("{:.4}", arena.published_sensitivity())) } });
        self.add("Mean sensitivity", "1/s", published, |group| {
            let mean = group.summary().pooled.mean_sensitivity;
            let values = group.values(|metrics| metrics.sensitivity);
            let count = count_of_defined(values.len(), group);
            html! { b { (number_or_dash(mean, 4)) } (interval(&values, 2)) (count) }
        });
        let published = arena.map(|arena| {
            html! { (PUBLISHED_NORMALISED_SENSITIVITY) small { "n = " (format_number(arena.published_n(), 0)) } }
        });
        self.add("Normalised by n", "1/s", published, |group| {
            let pooled = group.summary().pooled;
            let n =
                pooled.mean_sensitivity.zip(pooled.normalised_sensitivity).map(|(mean, by_n)| mean / by_n);
            html! {
                (number_or_dash(pooled.normalised_sensitivity, 4))
                @if let Some(n) = n.filter(|n| n.is_finite()) {
                    small { "n = " (format_number(n, usize::from(arena.is_none()))) }
                }
            }
        });
    }
}

/// How many trials of a group a mean rests on; empty where it rests on all.
fn count_of_defined(count: usize, group: &TrialGroup<'_>) -> Markup {
    html! { @if count < group.trials.len() { small { "of " (count) " trials that have it" } } }
}

/// The 95 % interval of a mean; empty where it is undefined.
fn interval(values: &[f64], decimals: usize) -> Markup {
    html! {
        @if let Some(interval) = mean_interval(values) {
            small { (format_number(interval.low, decimals)) " to " (format_number(interval.high, decimals)) }
        }
    }
}

/// All trials, each with a sparkline of P; the name links to the trial's figures.
pub(super) fn trials_table(trials: &[ReportedTrial]) -> Markup {
    // The law of a trial stands in the name of its set.
    let has_sets = trials.iter().any(|trial| trial.set != trials[0].set);
    html! {
        div class="scroll" {
            table class="trials" {
                thead {
                    tr {
                        th { "Trial" }
                        @if has_sets { th { "Set" } }
                        th { "P over time" }
                        th { "Length, s" }
                        th { "Excursions" small { "complete" } }
                        th { "Outside, s" }
                        th { "Largest P" }
                        th { "\u{222b}|rate|, rad" }
                        th { "\u{222b}rate\u{b2}, rad\u{b2}/s" }
                        th { "Moves" }
                        th { "Switches" }
                        th { "s, 1/s" }
                    }
                }
                tbody {
                    @for (index, trial) in trials.iter().enumerate() { (trial_row(index, trial, has_sets)) }
                }
            }
        }
    }
}

fn trial_row(index: usize, trial: &ReportedTrial, has_sets: bool) -> Markup {
    let (m, name) = (&trial.entry.metrics, &trial.entry.name);
    html! {
        tr {
            th scope="row" {
                @if trial.trace.is_some() { a href={ "#t" (index) } { (Text(name)) } } @else { (Text(name)) }
                (flags(trial))
            }
            @if has_sets { td class="set" { (Text(&trial.set.name)) } }
            td class="spark" {
                @match &trial.trace {
                    Some(trace) => (PreEscaped(sparkline::figure(name, trace).inline())),
                    None => small { "metrics only" },
                }
            }
            td { (format_number(m.duration_s, 1)) }
            td {
                (m.excursions)
                @if m.complete_excursions != m.excursions { small { (m.complete_excursions) " complete" } }
            }
            td { (format_number(m.time_outside_s, 1)) }
            td { (number_or_dash(m.max_p, 2)) }
            td { (number_or_dash(m.travel_rad, 2)) }
            td { (number_or_dash(m.effort_rad2_per_s, 2)) }
            td { (count_or_dash(m.moves)) }
            td { (count_or_dash(m.switches)) }
            td { (number_or_dash(m.sensitivity, 3)) }
        }
    }
}

fn count_or_dash(count: Option<usize>) -> String {
    count.map_or_else(|| "\u{2013}".to_owned(), |count| count.to_string())
}

/// A mark where a trial failed or ends outside the region.
pub(super) fn flags(trial: &ReportedTrial) -> Markup {
    let metrics = &trial.entry.metrics;
    let flag = match (metrics.lost == Some(true), metrics.ends_outside) {
        (true, _)
            if matches!(trial.set.kind, SetKind::Recorded | SetKind::Sortie) && !metrics.is_in_pixels() =>
        {
            Some("track lost")
        }
        (true, _) => Some("lost"),
        (false, _) if metrics.is_in_pixels() && !metrics.is_success() => Some("not tracked"),
        (false, true) => Some("ends outside"),
        (false, false) => None,
    };
    html! { @if let Some(flag) = flag { em { (flag) } } }
}
