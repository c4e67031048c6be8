//! The part of the page about sorties: the summary of each, as `barrelman library` gives it, and its moments.

use maud::{Markup, html};

use super::reported_trial::ReportedTrial;
use super::text::{Text, format_number};
use crate::sortie::{Sortie, length};

/// A section with the summary of each sortie; nothing where there is none.
pub(super) fn section(trials: &[ReportedTrial]) -> Markup {
    let sorties: Vec<(&str, &Sortie)> =
        trials.iter().filter_map(|trial| Some((trial.entry.name.as_str(), trial.sortie.as_ref()?))).collect();
    html! {
        @if !sorties.is_empty() {
            section {
                h2 { @if sorties.len() == 1 { "The sortie" } @else { "The sorties" } }
                @for (name, sortie) in sorties { (summary(name, sortie)) }
            } "\n"
        }
    }
}

fn summary(name: &str, sortie: &Sortie) -> Markup {
    html! {
        h3 { (Text(name)) }
        ul {
            li { (length(sortie.length_s)) }
            @for line in sortie.lines() { li { (Text(&line)) } }
        }
        @if !sortie.moments.is_empty() {
            table {
                thead { tr { th { "time, s" } th { "moment" } } }
                tbody {
                    @for moment in &sortie.moments {
                        tr { td { (format_number(moment.at_s, 1)) } td { (Text(&moment.what.text())) } }
                    }
                }
            }
        }
    }
}
