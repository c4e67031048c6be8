//! Received bytes to reports and prompts, independent of how the bytes were grouped by the reads.

use barrelman_vocab::telemetry::Report;

use super::lines::LineSplitter;
use super::telemetry::parse;

/// The shell's prompt.
pub const PROMPT: &str = "nsh>";

/// What received bytes mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Received {
    /// The shell's prompt.
    Prompt,
    /// A telemetry line.
    Report(Report),
}

/// Reads telemetry lines and prompts.
#[derive(Debug, Clone, Default)]
pub struct TelemetryReader {
    lines: LineSplitter,
}

impl TelemetryReader {
    /// Passes the meaning of received bytes to `each`. Lines without a known meaning are skipped.
    pub fn read(&mut self, bytes: &[u8], mut each: impl FnMut(Received)) {
        for &byte in bytes {
            let mut meaning = None;
            self.lines.feed(&[byte], |line| meaning = parse(line.trim_start()));
            if self.lines.partial().trim_start() == PROMPT {
                self.lines.discard_partial();
                each(Received::Prompt);
            }
            if let Some(report) = meaning {
                each(Received::Report(report));
            }
        }
    }
}
