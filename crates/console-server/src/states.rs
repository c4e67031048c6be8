//! The words of laws, causes, alarms and drills as a module of the page: those of the terminal, from the same
//! types.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use barrelman_vocab::{DrillName, HoldCause, LawId, Named, StopCause};
use serde_json::json;

use crate::snapshot::Alarm;

/// Name of the module, in English. A page in another language has these words in its own table.
pub(super) const NAME: &str = "states.en.js";

/// The module.
pub(super) static MODULE: LazyLock<String> = LazyLock::new(|| {
    let causes: BTreeMap<_, _> = words::<HoldCause>().chain(words::<StopCause>()).collect();
    let alarms: BTreeMap<_, _> = words::<Alarm>().collect();
    let laws: BTreeMap<_, _> = words::<LawId>().collect();
    let drills: Vec<_> = DrillName::ALL
        .iter()
        .map(|drill| json!({ "name": drill.key(), "title": drill.text(), "task": drill.task() }))
        .collect();
    let all = json!({ "causes": causes, "alarms": alarms, "laws": laws, "drills": drills });
    format!("export default {all:#};\n")
});

fn words<T: Named>() -> impl Iterator<Item = (&'static str, &'static str)> {
    T::ALL.iter().map(|name| (name.key(), name.text()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_of_hold_and_stop_has_one_text() {
        let stops: BTreeMap<_, _> = words::<StopCause>().collect();
        let both: Vec<_> = words::<HoldCause>().filter(|(key, _)| stops.contains_key(key)).collect();
        assert_eq!(both.len(), 2);
        for (key, text) in both {
            assert_eq!(stops[key], text, "{key}");
        }
    }

    #[test]
    fn every_text_begins_in_lower_case_and_ends_without_a_full_stop() {
        let states = words::<HoldCause>().chain(words::<StopCause>()).chain(words::<Alarm>());
        for (_, text) in states.chain(words::<LawId>()).chain(words::<DrillName>()) {
            assert!(
                !text.ends_with('.') && (text.starts_with("PID") || !text.starts_with(char::is_uppercase)),
                "{text}"
            );
        }
    }
}
