//! The results of `barrelman check`.

use serde::Serialize;

/// Whether what was checked is usable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Verdict {
    Ok,
    Warning,
    Failed,
}

/// The result of one check, as printed.
#[derive(Debug, Serialize)]
pub(super) struct CheckResult {
    #[serde(rename = "what")]
    pub(super) subject: String,
    pub(super) verdict: Verdict,
    pub(super) details: String,
}

impl CheckResult {
    pub(super) fn new(subject: impl Into<String>, verdict: Verdict, details: impl Into<String>) -> Self {
        Self { subject: subject.into(), verdict, details: details.into() }
    }
}
