//! The error for options that contradict each other.

/// Options that make no sense together, or one that is missing: exit code 2, as for what clap refuses.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct WrongUse(pub String);
