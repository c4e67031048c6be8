//! The page: claims and counts, the arenas, the list of trials, and the figures of each trial.
//!
//! The page is HTML and well-formed XML. It contains everything it needs and does not use the network.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::figure::Figure;
use super::reported_trial::{ReportedTrial, SetKind, TrialTrace};
use super::text::{Text, count_of, format_number, number_or_dash, to_file_name};
use super::trial_group::{TrialGroup, by_arena};
use super::{
    claims, columns, commands, natural_order, p_over_time, picture_path, sensitivity, sortie, style, tables,
    water_map, world_path,
};
use crate::metrics::Arena;

/// A report of trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The trials, in the order of the list.
    pub trials: Vec<ReportedTrial>,
    /// Version of the program.
    pub version: String,
}

/// A report of at most this many trials unfolds the figures of all; a larger one those of the first trial of
/// each group.
const MAX_UNFOLDED: usize = 3;
/// Figures wider than this, in units of paper, have a row of their own.
const MAX_NARROW: f64 = 500.0;

const PAGE_STYLE: &str = include_str!("page.css");

/// Elements without content: the templates would write them without the slash that XML needs.
const META: PreEscaped<&str> = PreEscaped(
    "<meta charset=\"utf-8\"/><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>",
);

/// Unfolds the figures that a link leads to, and all figures for print.
const SCRIPT: &str = "const open=()=>{const t=document.getElementById(location.hash.slice(1));\
    if(t?.tagName==='DETAILS'){t.open=true;t.scrollIntoView()}};\
    addEventListener('hashchange',open);addEventListener('DOMContentLoaded',open);\
    addEventListener('beforeprint',()=>document.querySelectorAll('details').forEach(d=>d.open=true));";

impl Report {
    /// A report of these trials, in the order of their arenas and sets, and of their names within a set: by
    /// the numbers in them.
    pub fn new(mut trials: Vec<ReportedTrial>, version: String) -> Self {
        let place = |trial: &ReportedTrial| (trial.entry.arena.is_none(), trial.entry.arena);
        trials.sort_by(|a, b| {
            let sets = (place(a), &a.set).cmp(&(place(b), &b.set));
            sets.then_with(|| natural_order::compare(&a.entry.name, &b.entry.name))
        });
        Self { trials, version }
    }

    /// Every figure, each with the name of its file.
    pub fn figures(&self) -> Vec<Figure> {
        let arenas = by_arena(&self.trials);
        let mut figures: Vec<Figure> =
            arenas.iter().filter_map(|(arena, groups)| sensitivity_figure(*arena, groups)).collect();
        for (index, trial) in self.trials.iter().enumerate() {
            if let Some(trace) = &trial.trace {
                figures.extend(trial_figures(index, &trial.entry.name, trace));
            }
        }
        figures
    }

    /// The self-contained HTML page.
    pub fn page(&self) -> String {
        let arenas = by_arena(&self.trials);
        let groups: Vec<&TrialGroup<'_>> = arenas.iter().flat_map(|(_, groups)| groups).collect();
        let is_of_sorties = self.is_of_sorties();
        let page = html! {
            (DOCTYPE) "\n"
            html lang="en-GB" {
                (head()) "\n"
                body {
                    header {
                        p class="brand" { "Barrelman report" }
                        h1 { "Keeping a boat in view: what the camera did" }
                        (self.lede())
                    } "\n"
                    (sortie::section(&self.trials))
                    @if !is_of_sorties {
                        section { h2 { "Claimed and counted" } (claims::paragraphs(&groups)) } "\n"
                    }
                    @for (arena, groups) in &arenas { (arena_section(*arena, groups)) "\n" }
                    section {
                        h2 { (if is_of_sorties { "Figures" } else { "All trials" }) }
                        (tables::trials_table(&self.trials)) (columns::definitions())
                    } "\n"
                    (self.trial_sections(&groups))
                    (notes()) "\n"
                    footer {
                        p {
                            "Made by barrelman " (Text(&self.version)) ", without a clock and without the network: the \
                             same logs give the same page."
                        }
                    }
                    script { (PreEscaped(SCRIPT)) }
                }
            } "\n"
        };
        page.into_string()
    }

    /// Whether all trials are sorties: the paper's claims are about others.
    fn is_of_sorties(&self) -> bool {
        !self.trials.is_empty() && self.trials.iter().all(|trial| trial.set.kind == SetKind::Sortie)
    }

    /// What the report is of, such as "1 sortie and 2 laboratory logs".
    pub fn contents(&self) -> String {
        let count = |kind: SetKind| self.trials.iter().filter(|trial| trial.set.kind == kind).count();
        let kinds = [
            (count(SetKind::Laboratory), "laboratory log"),
            (count(SetKind::Simulated), "simulated trial"),
            (count(SetKind::Recorded), "recorded trial"),
            (count(SetKind::Sortie), "sortie"),
        ];
        let parts: Vec<String> = kinds
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, noun)| count_of(*count, noun))
            .collect();
        if parts.is_empty() { "no trials".to_owned() } else { parts.join(" and ") }
    }

    /// A sentence with what the report is of and the total duration.
    fn lede(&self) -> Markup {
        let seconds: f64 = self.trials.iter().map(|trial| trial.entry.metrics.duration_s).sum();
        let minutes = format_number(seconds / 60.0, 1);
        html! { p class="lede" { (self.contents()) ", " (minutes) " minutes" @if self.trials.len() > 1 { " together" } "." } }
    }

    fn trial_sections(&self, groups: &[&TrialGroup<'_>]) -> Markup {
        let is_unfolded = |trial: &ReportedTrial| {
            let firsts =
                groups.iter().filter_map(|group| group.trials.iter().find(|trial| trial.trace.is_some()));
            self.trials.len() <= MAX_UNFOLDED || firsts.into_iter().any(|first| core::ptr::eq(*first, trial))
        };
        html! {
            @if self.trials.iter().any(|trial| trial.trace.is_some()) {
                section {
                    h2 { (if self.is_of_sorties() { "Sortie by sortie" } else { "Trial by trial" }) }
                    p class="caption" {
                        "P over time: each excursion is shaded from the row that leaves the region to the one that is \
                         back; its height above 1 is h, its length b. Below it the commands, at the same times; then the \
                         path in the picture with the region and the sectors at \u{00b1}45\u{00b0}, excursions in colour \
                         and numbered in time (\u{25cb} start, \u{25cf} end), and for simulated trials the path in the \
                         world from above. Where a boat was commanded, a map of the water as the program knew it: the \
                         boat\u{2019}s way, the marks with their circles, what the picture showed at the beginning \
                         (dashed) and at the end."
                    }
                    @for (index, trial) in self.trials.iter().enumerate() {
                        @if let Some(trace) = &trial.trace {
                            (trial_details(index, trial, trace, is_unfolded(trial))) "\n"
                        }
                    }
                } "\n"
            }
        }
    }
}

fn head() -> Markup {
    html! {
        head {
            (META)
            title { "Trials of a camera that keeps a boat in view" } "\n"
            style {
                (PreEscaped(style::properties())) "\n" (PreEscaped(style::light_and_dark())) "\n"
                (PreEscaped(PAGE_STYLE))
            }
        }
    }
}

fn arena_section(arena: Option<Arena>, groups: &[TrialGroup<'_>]) -> Markup {
    html! {
        section {
            h2 {
                @match arena { Some(arena) => { "Arena " (arena.number()) }, None if groups.iter().all(|group| group.set.kind == SetKind::Sortie) => "Means",
                    None => "Other scenarios" }
            }
            @if let Some(figure) = sensitivity_figure(arena, groups) {
                figure class="scroll wide" { (PreEscaped(figure.inline())) }
                p class="caption" {
                    "Every dot is a trial; a ring is one that was lost or ends outside. Upright line and band: the mean \
                     and its 95\u{a0}% interval."
                }
            }
            @if arena.is_some() && groups.iter().any(|group| group.set.kind == SetKind::Simulated) {
                p class="caption" { (published_is_of_another_tracker()) }
            }
            (tables::arena_table(arena, groups))
        }
    }
}

/// Why a published sensitivity above a simulated one does not say that the law here is better.
fn published_is_of_another_tracker() -> Markup {
    html! {
        b { "The published sensitivity is no measure for the simulated trials." }
        " It contains leaps of the paper\u{2019}s tracker, by 40 to 290\u{a0}px and back within a second, which make about \
         half of it: without the excursions in which the tracker leapt, the recorded trials have 0.29 (arena\u{a0}1) and \
         0.27\u{a0}1/s (arena\u{a0}2). A simulated trial from truth has no such leaps. (The paper: "
        a href="https://arxiv.org/abs/1710.02932" { "arXiv\u{a0}1710.02932" }
        "; the count: docs/simulation.md, \u{2018}How the published sensitivities come about\u{2019}.)"
    }
}

/// The figures of one trial, folded or not.
fn trial_details(index: usize, trial: &ReportedTrial, trace: &TrialTrace, is_unfolded: bool) -> Markup {
    let m = &trial.entry.metrics;
    let (wide, narrow): (Vec<Figure>, Vec<Figure>) = trial_figures(index, &trial.entry.name, trace)
        .into_iter()
        .partition(|figure| figure.width > MAX_NARROW);
    html! {
        details id={ "t" (index) } open=[is_unfolded.then_some("open")] {
            summary {
                b { (Text(&trial.entry.name)) } " "
                span {
                    (Text(&trial.set.name)) " \u{00b7} " (format_number(m.duration_s, 1)) "\u{a0}s \u{00b7} "
                    (m.excursions) " excursions \u{00b7} s\u{a0}=\u{a0}" (number_or_dash(m.sensitivity, 3)) " "
                    (tables::flags(trial))
                }
            }
            figure class="scroll wide" { @for figure in &wide { (PreEscaped(figure.inline())) } }
            figure class="pair" { @for figure in &narrow { (PreEscaped(figure.inline())) } }
        }
    }
}

fn notes() -> Markup {
    html! {
        section class="notes" {
            h2 { "How this was counted" }
            p {
                "An " i { "excursion" } " is a maximal run of rows with P\u{a0}>\u{a0}1; it is complete when the log goes \
                 on after it. h is its largest P less 1, b its duration. A trial\u{2019}s sensitivity s is the mean of h/b \
                 over its complete excursions; a set\u{2019}s is the mean of s. The paper (Biswas et al. 2017) defines s \
                 in words and a figure only: this reading is a reconstruction. On the 30 laboratory logs it gives 0.6055 \
                 and 0.4535 where the paper has 0.6045 and 0.4536."
            }
            p {
                "Normalised: divided by n, 18 and 13 in the paper, which are not the mean counts of excursions in the \
                 logs. Scenarios outside the paper\u{2019}s arenas are divided by their own mean count. Intervals are \
                 Student\u{2019}s, 95\u{a0}%, over trials. A few excursions in which the tracker jumped carry much of the \
                 laboratory\u{2019}s means: look at the dots before comparing means. Rates are those commanded, not those \
                 achieved."
            }
        }
    }
}

fn sensitivity_figure(arena: Option<Arena>, groups: &[TrialGroup<'_>]) -> Option<Figure> {
    let name =
        arena.map_or_else(|| "sensitivity-other".to_owned(), |a| format!("sensitivity-arena-{}", a.number()));
    sensitivity::figure(&name, arena, groups)
}

/// The figures of one trial.
fn trial_figures(index: usize, trial: &str, trace: &TrialTrace) -> Vec<Figure> {
    let name = |kind: &str| format!("{:03}-{}-{kind}", index + 1, to_file_name(trial));
    [
        Some(p_over_time::figure(&name("p"), trial, trace)),
        commands::figure(&name("commands"), trial, trace),
        Some(picture_path::figure(&name("picture"), trial, trace)),
        world_path::figure(&name("world"), trial, trace),
        water_map::figure(&name("water"), trial, trace),
    ]
    .into_iter()
    .flatten()
    .collect()
}
