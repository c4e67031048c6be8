//! Lines and fields of CSV logs.

use super::log_error::LogError;
use super::trial_log::TrialLog;

/// A log as far as it could be read.
#[derive(Debug, Clone, PartialEq)]
pub struct ParsedLog {
    /// The complete rows.
    pub log: TrialLog,
    /// The line (from 1) at which the file is truncated: a last line without a line end.
    pub truncated_at_line: Option<usize>,
}

/// The complete lines with their numbers (from 1), and the number of a last line without a line end.
pub(super) fn complete_lines(text: &str) -> (Vec<(usize, &str)>, Option<usize>) {
    let mut lines: Vec<(usize, &str)> =
        text.split_inclusive('\n').enumerate().map(|(index, line)| (index + 1, line)).collect();
    let truncated = match lines.last() {
        Some((number, line)) if !line.ends_with('\n') => Some(*number),
        _ => None,
    };
    if truncated.is_some() {
        lines.pop();
    }
    (lines, truncated)
}

/// Parses a finite number.
pub(super) fn parse_number(text: &str, line: usize, column: &'static str) -> Result<f64, LogError> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| LogError::NotANumber {
        line,
        column,
        found: text.trim().to_owned(),
    })
}

/// Parses a finite number; `None` where the field is blank.
pub(super) fn parse_optional_number(
    text: &str,
    line: usize,
    column: &'static str,
) -> Result<Option<f64>, LogError> {
    if text.trim().is_empty() { Ok(None) } else { parse_number(text, line, column).map(Some) }
}
