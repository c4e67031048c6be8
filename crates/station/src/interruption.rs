//! Signals that end a command: the first asks it to end in good order, a second one ends the program at once.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

/// The exit code of a program that a second signal ends: that of a shell for a program that Ctrl-C ended.
const ENDED_BY_SIGNAL: i32 = 130;

/// A flag that Ctrl-C, SIGTERM or SIGHUP sets. The next Ctrl-C or SIGTERM ends the program at once. (Another
/// SIGHUP may come of the end itself, from a terminal that the program closes.)
///
/// # Errors
/// If the signals cannot be caught.
pub(crate) fn flag_of_signals() -> Result<Arc<AtomicBool>> {
    let asked = Arc::new(AtomicBool::new(false));
    let catch = || -> std::io::Result<()> {
        // Before the flag is registered: the first signal finds it unset.
        for signal in [SIGINT, SIGTERM] {
            flag::register_conditional_shutdown(signal, ENDED_BY_SIGNAL, Arc::clone(&asked))?;
        }
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            flag::register(signal, Arc::clone(&asked))?;
        }
        Ok(())
    };
    catch().context("signals cannot be caught")?;
    Ok(asked)
}
