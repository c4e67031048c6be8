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
    failed: Vec<&'a str>,
}

impl<'a> Count<'a> {
    fn of_kind(kind: SetKind, groups: &[&'a TrialGroup<'_>]) -> Self {
        let trials = || {
            groups.iter().copied().filter(move |group| group.set.kind == kind).flat_map(|group| &group.trials)
        };
        let failed = trials().filter(|trial| !trial.entry.metrics.is_success());
        Self { all: trials().count(), failed: failed.map(|trial| trial.entry.name.as_str()).collect() }
    }

    fn failed(&self) -> usize {
        self.failed.len()
    }

    /// The number of failed trials in a sentence.
    fn failed_or_none(&self) -> String {
        if self.failed.is_empty() { "none".to_owned() } else { self.failed().to_string() }
    }

    /// The names of the failed trials: `: a, b and c`; empty where there are none.
    fn failed_names(&self) -> String {
        let Some((last, others)) = self.failed.split_last() else { return String::new() };
        if self.failed.len() > MAX_NAMED {
            let first = self.failed[..MAX_NAMED].join(", ");
            return format!(": {first} and {} more", self.failed.len() - MAX_NAMED);
        }
        if others.is_empty() {
            return format!(": {last}");
        }
        format!(": {} and {last}", others.join(", "))
    }
}
