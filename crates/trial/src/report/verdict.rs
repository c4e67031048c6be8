//! What is claimed and what was counted, in words.

use super::sets::{Group, SetKind};
use super::text::{counted, escaped};

/// As many trials are named, the others counted.
const MOST_NAMED: usize = 12;

/// A paragraph of HTML for each kind of trial.
pub(super) fn paragraphs(groups: &[&Group<'_>]) -> String {
    let mut html = String::new();
    let of = |kind: SetKind| groups.iter().copied().filter(move |group| group.set.kind == kind);
    let count = |kind| of(kind).map(|group| group.trials.len()).sum::<usize>();
    let succeeded = |kind| of(kind).map(Group::succeeded).sum::<usize>();
    let failed = |kind| {
        let trials = of(kind).flat_map(|group| &group.trials);
        let names: Vec<&str> =
            trials.filter(|t| !t.entry.metrics.succeeded()).map(|t| t.entry.name.as_str()).collect();
        named(&names)
    };
    if count(SetKind::Laboratory) > 0 {
        let all = count(SetKind::Laboratory);
        let outside = all - succeeded(SetKind::Laboratory);
        let end = if outside <= 1 { "ends" } else { "end" };
        html += &format!(
            "<p><strong>The paper claims 100\u{a0}% success; of {} {} {end} outside the \
             ellipse{}.</strong> A log holds where the tracker thought the target was, clamped to the picture, so it \
             cannot tell whether the target was still in view; what can be counted is whether the last row has \
             P\u{a0}>\u{a0}1.</p>",
            counted(all, "laboratory log"),
            or_none(outside),
            failed(SetKind::Laboratory)
        );
    }
    if count(SetKind::Simulated) > 0 {
        let all = count(SetKind::Simulated);
        let lost = all - succeeded(SetKind::Simulated);
        html += &format!(
            "<p><strong>Of {} {} lost the target{}.</strong> Lost means out of the picture for \
             over 2\u{a0}s at a stretch, or at the end, by the simulator\u{2019}s truth.</p>",
            counted(all, "simulated trial"),
            or_none(lost),
            failed(SetKind::Simulated)
        );
    }
    if count(SetKind::Recorded) > 0 {
        let all = count(SetKind::Recorded);
        let lost = all - succeeded(SetKind::Recorded);
        html += &format!(
            "<p><strong>Of {} {} lost the target{}.</strong> Lost means that the track was lost \
             for over 2\u{a0}s at a stretch, or at the end; where a log cannot tell, that it ends outside the ellipse.</p>",
            counted(all, "recorded trial"),
            or_none(lost),
            failed(SetKind::Recorded)
        );
    }
    if count(SetKind::Laboratory) > 0 && count(SetKind::Simulated) + count(SetKind::Recorded) > 0 {
        html += "<p>These counts go by different rules, because a laboratory log cannot tell more. \
                 \u{2018}Ends outside\u{2019} in the tables is the same for all.</p>";
    }
    html
}

/// A count in a sentence.
fn or_none(count: usize) -> String {
    if count == 0 { "none".to_owned() } else { count.to_string() }
}

/// `: a, b and c`, escaped; empty where there are none.
fn named(names: &[&str]) -> String {
    let Some((last, others)) = names.split_last() else { return String::new() };
    if names.len() > MOST_NAMED {
        let first: Vec<String> = names[..MOST_NAMED].iter().map(|name| escaped(name)).collect();
        return format!(": {} and {} more", first.join(", "), names.len() - MOST_NAMED);
    }
    if others.is_empty() {
        return format!(": {}", escaped(last));
    }
    let others: Vec<String> = others.iter().map(|name| escaped(name)).collect();
    format!(": {} and {}", others.join(", "), escaped(last))
}
