//! The error for options that contradict each other.

/// Options that contradict each other, or a missing option. The program ends with exit code 2, as for clap's
/// errors.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);
