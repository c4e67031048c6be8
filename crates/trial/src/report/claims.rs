//! The paper's claim and the counted results, in words.

use maud::{Markup, html};

use super::reported_trial::SetKind;
use super::text::{Text, count_of};
use super::trial_group::TrialGroup;

/// Upper bound of the trials named in a sentence; the others are counted.
const MAX_NAMED: usize = 12;

/// A paragraph for each source of trials.
pub(super) fn paragraphs(groups: &[&TrialGroup<'_>]) -> Markup {
    let laboratory = Count::of_kind(SetKind::Laboratory, groups);
    let simulated = Count::of_kind(SetKind::Simulated, groups);
    let recorded = Count::of_kind(SetKind::Recorded, groups);
    html! {
        @if laboratory.all > 0 {
            p {
                strong {
                    "The paper claims 100\u{a0}% success; of " (count_of(laboratory.all, "laboratory log")) " "
                    (laboratory.failed_or_none()) (if laboratory.failed() <= 1 { " ends" } else { " end" })
                    " outside the ellipse" (Text(&laboratory.failed_names())) "."
                }
                " A log holds where the tracker thought the target was, clamped to the picture, so it cannot tell \
                 whether the target was still in view; what can be counted is whether the last row has \
                 P\u{a0}>\u{a0}1."
            }
        }
        @if simulated.all > 0 {
            p {
                strong {
                    "Of " (count_of(simulated.all, "simulated trial")) " " (simulated.failed_or_none())
                    " lost the target" (Text(&simulated.failed_names())) "."
                }
                " Lost means out of the picture for over 2\u{a0}s at a stretch, or at the end, by the \
                 simulator\u{2019}s truth; in pixels also not tracked, though visible, for over 5\u{a0}s, or for \
                 over 5\u{a0}% of the time."
            }
        }
        @if recorded.all > 0 {
            p {
                strong {
                    "Of " (count_of(recorded.all, "recorded trial")) " " (recorded.failed_or_none())
                    " lost the target" (Text(&recorded.failed_names())) "."
                }
                " Lost means that the track was lost for over 2\u{a0}s at a stretch, or at the end; where a log cannot \
                 tell, that it ends outside the ellipse."
            }
        }
        @if laboratory.all > 0 && simulated.all + recorded.all > 0 {
            p {
                "These counts go by different rules, because a laboratory log cannot tell more. \
                 \u{2018}Ends outside\u{2019} in the tables is the same for all."
            }
        }
    }
}

/// The trials of one source, and those that failed.
struct Count<'a> {
    all: usize,
    /// Number of sets of this source.
    sets: usize,
    /// The failed trials of each set that has any: the set's name, and the names of the trials.
    failed: Vec<(&'a str, Vec<&'a str>)>,
}

impl<'a> Count<'a> {
    fn of_kind(kind: SetKind, groups: &[&'a TrialGroup<'_>]) -> Self {
        let groups = || groups.iter().copied().filter(move |group| group.set.kind == kind);
        let failed_of = |group: &'a TrialGroup<'_>| {
            let failed = group.trials.iter().filter(|trial| !trial.entry.metrics.is_success());
            (group.set.name.as_str(), failed.map(|trial| trial.entry.name.as_str()).collect::<Vec<_>>())
        };
        Self {
            all: groups().map(|group| group.trials.len()).sum(),
            sets: groups().count(),
            failed: groups().map(failed_of).filter(|(_, names)| !names.is_empty()).collect(),
        }
    }

    fn failed(&self) -> usize {
        self.failed.iter().map(|(_, names)| names.len()).sum()
    }

    /// The number of failed trials in a sentence.
    fn failed_or_none(&self) -> String {
        if self.failed.is_empty() { "none".to_owned() } else { self.failed().to_string() }
    }

    /// The names of the failed trials: `: a, b and c`, with their set where there are several; empty without
    /// any.
    fn failed_names(&self) -> String {
        let of_set = |(set, names): &(&str, Vec<&str>)| {
            if self.sets > 1 { format!("{} ({set})", listed(names)) } else { listed(names) }
        };
        let sets: Vec<String> = self.failed.iter().map(of_set).collect();
        if sets.is_empty() { String::new() } else { format!(": {}", sets.join("; ")) }
    }
}

/// Names in a sentence.
fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [name] => (*name).to_owned(),
        _ if names.len() > MAX_NAMED => {
            format!("{} and {} more", names[..MAX_NAMED].join(", "), names.len() - MAX_NAMED)
        }
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    }
}
