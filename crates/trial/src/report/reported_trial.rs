//! The trials of a report.

use barrelman_control::Region;

use crate::logs::TrialLog;
use crate::metrics::TrialEntry;
use crate::sortie::Sortie;

/// A trial of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportedTrial {
    /// Name, arena and metrics.
    pub entry: TrialEntry,
    /// The set that the trial is counted in.
    pub set: TrialSet,
    /// The summary of a sortie; `None` for other trials.
    pub sortie: Option<Sortie>,
    /// The trial's log, for figures; `None` where only the metrics are known.
    pub trace: Option<TrialTrace>,
}

/// A log with the region that P refers to.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialTrace {
    /// The log.
    pub log: TrialLog,
    /// The region that P refers to.
    pub region: Region,
    /// P as the paper's motor schema would have kept it, row by row, where another law moved the camera.
    pub shadow: Option<Vec<Option<f64>>>,
}

/// Trials that are counted together.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct TrialSet {
    /// Source of the trials.
    pub kind: SetKind,
    /// Name of the set.
    pub name: String,
}

/// Source of trials. The order is that of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SetKind {
    /// The authors' laboratory logs.
    Laboratory,
    /// This program's simulator.
    Simulated,
    /// A log of unknown source.
    Recorded,
    /// A run, or a drive of the demo.
    Sortie,
}
