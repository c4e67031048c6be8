//! What a run came to.

use super::fault::Fault;

/// What a run came to.
#[derive(Debug)]
pub(super) struct RunResult {
    pub(super) faults: Vec<Fault>,
    /// The longest times to rest, in the order of the subject's figures, ms.
    pub(super) worst_ms: Vec<u64>,
    /// The licences that moved the vehicle.
    pub(super) moved: Vec<&'static str>,
    pub(super) violation: Option<(u64, String)>,
    /// Whether guard and program were gone together, for which there is no help.
    pub(super) is_excluded: bool,
}
