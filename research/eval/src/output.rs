//! How results are printed: one line at a time on standard output.

use std::io::Write;

/// Prints a line. A closed output is no error: a pipe to `head` ends the reader early.
pub(crate) fn print_line(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}
