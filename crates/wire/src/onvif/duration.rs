//! Durations as messages state them.

use core::time::Duration;

/// A duration in ISO 8601, also one that states years or months of zero. An empty text is no time. `None`: it
/// is none, is negative, or depends on the calendar.
pub(in crate::onvif) fn duration_of(text: &str) -> Option<Duration> {
    if text.trim().is_empty() {
        return Some(Duration::ZERO);
    }
    let span: jiff::Span = text.trim().parse().ok()?;
    span.to_duration(jiff::SpanRelativeTo::days_are_24_hours()).ok()?.try_into().ok()
}
