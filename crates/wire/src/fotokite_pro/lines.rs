//! Cuts received bytes into lines, wherever the reads happened to end.
//!
//! A line ends at `\r` or `\n`; empty lines (as `\r\n` makes them) are left out. A line that grows beyond
//! [`MAX_LINE_BYTES`] is not one of this protocol's: it is dropped up to its end. Bytes that are not
//! ASCII are kept as `?`, so that noise cannot join two lines.

/// Longest line that is kept, bytes. The longest telemetry line known has about 60.
pub const MAX_LINE_BYTES: usize = 512;

/// The line that is being received.
#[derive(Debug, Clone, Default)]
pub struct LineSplitter {
    partial: String,
    overlong: bool,
}

impl LineSplitter {
    /// Takes bytes as they were read and hands out each line that they complete, without its end.
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

    /// Forgets what was received of the line so far, as after a prompt: what follows begins a line.
    pub fn discard_partial(&mut self) {
        self.partial.clear();
    }

    /// What was received of a line whose end has not come yet: a shell's prompt is one.
    pub fn partial(&self) -> &str {
        &self.partial
    }
}
