//! Splits received bytes into lines, independent of how the bytes were grouped by the reads.
//!
//! A line ends at `\r` or `\n`. Empty lines (as in `\r\n`) are skipped. Lines longer than [`MAX_LINE_BYTES`]
//! are dropped. Bytes that are not ASCII are replaced by `?`, so that noise cannot join two lines.

/// Longest valid line, bytes. The longest known telemetry line has about 60.
pub const MAX_LINE_BYTES: usize = 512;

/// The splitter with the partial line.
#[derive(Debug, Clone, Default)]
pub struct LineSplitter {
    partial: String,
    overlong: bool,
}

impl LineSplitter {
    /// Processes received bytes and passes each completed line, without its end, to `line`.
    pub fn feed(&mut self, bytes: &[u8], mut line: impl FnMut(&str)) {
        for &byte in bytes {
            if byte == b'\r' || byte == b'\n' {
                if !self.overlong && !self.partial.is_empty() {
                    line(&self.partial);
                }
                self.partial.clear();
                self.overlong = false;
            } else if self.partial.len() == MAX_LINE_BYTES {
                self.overlong = true;
            } else {
                self.partial.push(if byte.is_ascii() && byte != 0 { char::from(byte) } else { '?' });
            }
        }
    }

    /// Discards the partial line, for example a prompt. The next byte starts a new line.
    pub fn discard_partial(&mut self) {
        self.partial.clear();
    }

    /// The partial line, for example a shell's prompt.
    pub fn partial(&self) -> &str {
        &self.partial
    }
}
