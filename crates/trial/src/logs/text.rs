//! Reads a text log of either kind.

use super::csv::ParsedLog;
use super::log_error::LogError;
use super::{exported, laboratory};

/// Reads a text log: the laboratory's or an exported one, by its header.
///
/// # Errors
/// [`LogError`] where the text is neither, or where a row cannot be parsed.
pub fn read_text(text: &str) -> Result<ParsedLog, LogError> {
    if text.starts_with(laboratory::HEADER) {
        laboratory::read(text)
    } else if exported::has_header(text) {
        exported::read(text)
    } else if text.trim().is_empty() {
        Err(LogError::Empty)
    } else {
        let found = text.lines().next().unwrap_or_default().chars().take(60).collect();
        Err(LogError::UnknownHeader { found })
    }
}
