//! What `barrelman check` and `barrelman doctor` found, as printed.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use anyhow::Result;
use serde::Serialize;

/// What a check found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Verdict {
    /// All is well.
    Ok,
    /// Something is missing, or is not as it should be.
    Warning,
    /// It cannot be used.
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

/// Prints results, in lines or as JSON. The exit code says whether one of them failed.
///
/// # Errors
/// If the output cannot be written.
pub(super) fn print(results: &[CheckResult], json: bool) -> Result<ExitCode> {
    let mut out = stdout().lock();
    if json {
        writeln!(out, "{}", serde_json::to_string_pretty(results)?)?;
    } else {
        for result in results {
            let mark = match result.verdict {
                Verdict::Ok => "ok     ",
                Verdict::Warning => "warning",
                Verdict::Failed => "FAILED ",
            };
            writeln!(out, "{mark}  {}: {}", result.subject, result.details)?;
        }
    }
    let has_failed = results.iter().any(|result| result.verdict == Verdict::Failed);
    Ok(if has_failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
