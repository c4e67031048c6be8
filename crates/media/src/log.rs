//! The error output, which goes to the program's log.

use std::io::{self, Write as _};

/// Writes a line. Nothing can be done where it cannot be written.
pub(crate) fn print_line(text: &str) {
    let _ = writeln!(io::stderr(), "barrelman-media: {text}");
}
