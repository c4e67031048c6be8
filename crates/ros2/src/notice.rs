//! What the program says of itself, on standard error.

use std::io::Write as _;

/// Writes a line. Where nobody reads, that is no failure.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "barrelman-ros2: {text}");
}
