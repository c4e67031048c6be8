//! The page: claims and counts, the arenas, the list of trials, and the figures of each.

use super::figure::Figure;
use super::sets::{Group, SetKind, by_arena};
use super::text::{counted, escaped, file_name, number, optional};
use super::{
    Course, ReportedTrial, arena_path, commands, p_over_time, picture_path, sensitivity, style, tables,
    verdict,
};
use crate::metrics::Arena;

/// A report of trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The trials, in the order in which they are listed.
    pub trials: Vec<ReportedTrial>,
    /// Version of the program.
    pub version: String,
}

/// Trials whose figures are unfolded from the start: all of so few, else the first of each group.
const FEW: usize = 3;

const PAGE_STYLE: &str = include_str!("page.css");

/// Unfolds the figures that a link leads to, and all of them on paper.
const SCRIPT: &str = "const open=()=>{const t=document.getElementById(location.hash.slice(1));\
    if(t?.tagName==='DETAILS'){t.open=true;t.scrollIntoView()}};\
    addEventListener('hashchange',open);addEventListener('DOMContentLoaded',open);\
    addEventListener('beforeprint',()=>document.querySelectorAll('details').forEach(d=>d.open=true));";

impl Report {
    /// Every figure, each with the name of its file.
    pub fn figures(&self) -> Vec<Figure> {
        let arenas = by_arena(&self.trials);
        let mut figures: Vec<Figure> =
            arenas.iter().filter_map(|(arena, groups)| sensitivity_of(*arena, groups)).collect();
        for (index, trial) in self.trials.iter().enumerate() {
            if let Some(course) = &trial.course {
                figures.extend(figures_of(index, &trial.entry.name, course));
            }
        }
        figures
    }

    /// The page: HTML that needs nothing but itself.
    pub fn page(&self) -> String {
        let arenas = by_arena(&self.trials);
        let groups: Vec<&Group<'_>> = arenas.iter().flat_map(|(_, groups)| groups).collect();
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en-GB\"><head><meta charset=\"utf-8\"/>\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
             <title>Trials of a camera that keeps a boat in view</title>\n<style>{}\n{}\n{PAGE_STYLE}</style></head>\n\
             <body><header><p class=\"brand\">Barrelman report</p>\
             <h1>Keeping a boat in view, with few movements of the camera</h1>{}</header>\n",
            style::properties(),
            style::by_day_and_night(),
            self.contents(&groups)
        );
        html += "<section><h2>Claimed and counted</h2>";
        html += &verdict::paragraphs(&groups);
        html += "</section>\n";
        for (arena, groups) in &arenas {
            html += &format!("<section><h2>{}</h2>", heading(*arena));
            if let Some(figure) = sensitivity_of(*arena, groups) {
                html += &format!("<figure class=\"scroll wide\">{}</figure>", figure.inline());
                html += "<p class=\"caption\">Every dot is a trial; a ring is one that was lost or ends outside. Upright \
                         line and band: the mean and its 95\u{a0}% interval.</p>";
            }
            html += &tables::of_arena(*arena, groups);
            html += "</section>\n";
        }
        html += "<section><h2>All trials</h2>";
        html += &tables::of_trials(&self.trials);
        html += "</section>\n";
        html += &self.trial_sections(&groups);
        html += NOTES;
        html += &format!(
            "<footer><p>Made by barrelman {}, without a clock and without the network: the same logs give the same \
             page.</p></footer><script>{SCRIPT}</script></body></html>\n",
            escaped(&self.version)
        );
        html
    }

    /// What is in here, in one sentence.
    fn contents(&self, groups: &[&Group<'_>]) -> String {
        let count = |kind: SetKind| {
            groups
                .iter()
                .filter(|group| group.set.kind == kind)
                .map(|group| group.trials.len())
                .sum::<usize>()
        };
        let kinds = [
            (count(SetKind::Laboratory), "laboratory log"),
            (count(SetKind::Simulated), "simulated trial"),
            (count(SetKind::Recorded), "recorded trial"),
        ];
        let parts: Vec<String> =
            kinds.iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(*count, what)).collect();
        let seconds: f64 = self.trials.iter().map(|trial| trial.entry.metrics.duration_s).sum();
        let parts = if parts.is_empty() { "no trials".to_owned() } else { parts.join(" and ") };
        format!("<p class=\"lede\">{parts}, {} minutes together.</p>", number(seconds / 60.0, 1))
    }

    fn trial_sections(&self, groups: &[&Group<'_>]) -> String {
        let is_open = |trial: &ReportedTrial| {
            let firsts =
                groups.iter().filter_map(|group| group.trials.iter().find(|trial| trial.course.is_some()));
            self.trials.len() <= FEW || firsts.into_iter().any(|first| core::ptr::eq(*first, trial))
        };
        let mut html = String::new();
        for (index, trial) in self.trials.iter().enumerate() {
            let Some(course) = &trial.course else { continue };
            let m = &trial.entry.metrics;
            html += &format!(
                "<details id=\"t{index}\"{}><summary><b>{}</b> <span>{} \u{00b7} {}\u{a0}s \u{00b7} {} excursions \
                 \u{00b7} s\u{a0}=\u{a0}{} {}</span></summary>",
                if is_open(trial) { " open=\"open\"" } else { "" },
                escaped(&trial.entry.name),
                escaped(&trial.set.name),
                number(m.duration_s, 1),
                m.excursions,
                optional(m.sensitivity, 3),
                tables::flags(trial),
            );
            let (wide, narrow): (Vec<Figure>, Vec<Figure>) = figures_of(index, &trial.entry.name, course)
                .into_iter()
                .partition(|figure| figure.width > 500.0);
            html += "<figure class=\"scroll wide\">";
            html.extend(wide.iter().map(Figure::inline));
            html += "</figure><figure class=\"pair\">";
            html.extend(narrow.iter().map(Figure::inline));
            html += "</figure></details>\n";
        }
        if html.is_empty() {
            return html;
        }
        format!(
            "<section><h2>Trial by trial</h2><p class=\"caption\">P over time: each excursion is shaded from the row that \
             leaves the region to the one that is back; its height above 1 is h, its length b. Below it the commands, at \
             the same times; then the path in the picture with the region and the sectors at \u{00b1}45\u{00b0}, \
             excursions in colour and numbered in time (\u{25cb} start, \u{25cf} end), and for simulated trials the path \
             in the world from above.</p>{html}</section>\n"
        )
    }
}

const NOTES: &str = "<section class=\"notes\"><h2>How this was counted</h2>\
    <p>An <i>excursion</i> is a maximal run of rows with P\u{a0}>\u{a0}1; it is complete when the log goes on after it. h is \
    its largest P less 1, b its duration. A trial\u{2019}s sensitivity s is the mean of h/b over its complete excursions; a \
    set\u{2019}s is the mean of s. The paper (Biswas et al. 2017) defines s in words and a figure only: this reading is a \
    reconstruction. On the 30 laboratory logs it gives 0.6055 and 0.4535 where the paper has 0.6045 and 0.4536.</p>\
    <p>Normalised: divided by n, 18 and 13 in the paper, which are not the mean counts of excursions in the logs. Scenarios \
    outside the paper\u{2019}s arenas are divided by their own mean count. Intervals are Student\u{2019}s, 95\u{a0}%, over \
    trials. A few excursions in which the tracker jumped carry much of the laboratory\u{2019}s means: look at the dots before \
    comparing means. Rates are those commanded, not those achieved.</p></section>\n";

fn heading(arena: Option<Arena>) -> String {
    arena.map_or_else(|| "Other scenarios".to_owned(), |arena| format!("Arena {}", arena.number()))
}

fn sensitivity_of(arena: Option<Arena>, groups: &[Group<'_>]) -> Option<Figure> {
    let name =
        arena.map_or_else(|| "sensitivity-other".to_owned(), |a| format!("sensitivity-arena-{}", a.number()));
    sensitivity::figure(&name, arena, groups)
}

/// The figures of one trial.
fn figures_of(index: usize, trial: &str, course: &Course) -> Vec<Figure> {
    let name = |what: &str| format!("{:03}-{}-{what}", index + 1, file_name(trial));
    [
        Some(p_over_time::figure(&name("p"), trial, course)),
        commands::figure(&name("commands"), trial, course),
        Some(picture_path::figure(&name("picture"), trial, course)),
        arena_path::figure(&name("world"), trial, course),
    ]
    .into_iter()
    .flatten()
    .collect()
}
