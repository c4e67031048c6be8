//! Which trials are counted together: those of one arena and one source.

use std::collections::BTreeMap;

use super::ReportedTrial;
use crate::metrics::{Arena, Summary, TrialMetrics, summarise};

/// Where trials come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SetKind {
    /// The authors' laboratory logs.
    Laboratory,
    /// Our simulator.
    Simulated,
    /// A run on real or recorded video, or a log that does not say.
    Recorded,
}

/// Trials that are counted together.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct TrialSet {
    /// Where they come from.
    pub kind: SetKind,
    /// What they are called.
    pub name: String,
}

/// The trials of one set in one arena.
#[derive(Debug, Clone)]
pub(super) struct Group<'a> {
    pub(super) set: &'a TrialSet,
    pub(super) trials: Vec<&'a ReportedTrial>,
}

impl Group<'_> {
    /// Their pooled figures.
    pub(super) fn summary(&self) -> Summary {
        summarise(self.trials.iter().map(|trial| trial.entry.clone()).collect())
    }

    /// A figure of each trial that has it.
    pub(super) fn values(&self, of: fn(&TrialMetrics) -> Option<f64>) -> Vec<f64> {
        self.trials.iter().filter_map(|trial| of(&trial.entry.metrics)).collect()
    }

    /// How many succeeded.
    pub(super) fn succeeded(&self) -> usize {
        self.trials.iter().filter(|trial| trial.entry.metrics.succeeded()).count()
    }
}

/// The groups of each arena: the paper's first, then what was in none of them.
pub(super) fn by_arena(trials: &[ReportedTrial]) -> Vec<(Option<Arena>, Vec<Group<'_>>)> {
    let mut groups: BTreeMap<(bool, Option<Arena>), BTreeMap<&TrialSet, Group<'_>>> = BTreeMap::new();
    for trial in trials {
        let (arena, set) = (trial.entry.arena, &trial.set);
        let sets = groups.entry((arena.is_none(), arena)).or_default();
        let group = sets.entry(set).or_insert_with(|| Group { set, trials: Vec::new() });
        group.trials.push(trial);
    }
    groups.into_iter().map(|((_, arena), sets)| (arena, sets.into_values().collect())).collect()
}
