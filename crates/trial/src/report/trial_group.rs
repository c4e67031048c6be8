//! Groups of trials that are counted together: those of one arena and one set.

use std::collections::BTreeMap;

use super::reported_trial::{ReportedTrial, TrialSet};
use crate::metrics::{Arena, Summary, TrialMetrics, summarise};

/// The trials of one set in one arena.
#[derive(Debug, Clone)]
pub(super) struct TrialGroup<'a> {
    pub(super) set: &'a TrialSet,
    pub(super) trials: Vec<&'a ReportedTrial>,
}

impl TrialGroup<'_> {
    /// The pooled metrics.
    pub(super) fn summary(&self) -> Summary {
        summarise(self.trials.iter().map(|trial| trial.entry.clone()).collect())
    }

    /// A metric of each trial that defines it.
    pub(super) fn values(&self, value_of: fn(&TrialMetrics) -> Option<f64>) -> Vec<f64> {
        self.trials.iter().filter_map(|trial| value_of(&trial.entry.metrics)).collect()
    }

    /// Number of successful trials.
    pub(super) fn success_count(&self) -> usize {
        self.trials.iter().filter(|trial| trial.entry.metrics.is_success()).count()
    }
}

/// The groups by arena: the paper's arenas first, then the trials outside of them.
pub(super) fn by_arena(trials: &[ReportedTrial]) -> Vec<(Option<Arena>, Vec<TrialGroup<'_>>)> {
    let mut groups: BTreeMap<(bool, Option<Arena>), BTreeMap<&TrialSet, TrialGroup<'_>>> = BTreeMap::new();
    for trial in trials {
        let (arena, set) = (trial.entry.arena, &trial.set);
        let sets = groups.entry((arena.is_none(), arena)).or_default();
        let group = sets.entry(set).or_insert_with(|| TrialGroup { set, trials: Vec::new() });
        group.trials.push(trial);
    }
    groups.into_iter().map(|((_, arena), sets)| (arena, sets.into_values().collect())).collect()
}
