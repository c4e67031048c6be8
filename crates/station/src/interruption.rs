//! Signals that end a command: the first asks it to end in good order, a second one ends the program at once.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

/// The exit code of a program that a second signal ends: that of a shell for a program that Ctrl-C ended.
const ENDED_BY_SIGNAL: i32 = 130;

/// A flag that Ctrl-C, SIGTERM or SIGHUP sets. The next of them ends the program at once.
///
/// # Errors
/// If the signals cannot be caught.
pub(crate) fn flag_of_signals() -> Result<Arc<AtomicBool>> {
    let asked = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // In this order: the first signal finds the flag unset.
        flag::register_conditional_shutdown(signal, ENDED_BY_SIGNAL, Arc::clone(&asked))
            .and_then(|_| flag::register(signal, Arc::clone(&asked)))
            .context("signals cannot be caught")?;
    }
    Ok(asked)
}
