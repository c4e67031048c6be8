//! Which guards a run needs.

use std::path::PathBuf;

use anyhow::Result;
use barrelman_pilot::CommandPath;

use crate::config::Configuration;
use crate::link::{LinkUrl, command_path, find_guard};

/// The guard's program, where the vehicle needs one: it keeps its last rate when this program is gone.
///
/// # Errors
/// If the guard is not there, and the operator has not said that the run does without it.
pub(in crate::commands) fn needed_guard(
    configuration: &Configuration,
    link: Option<&LinkUrl>,
) -> Result<Option<PathBuf>> {
    if command_path(link) != CommandPath::Link || !configuration.profile.keeps_last_rate() {
        return Ok(None);
    }
    if configuration.guard.is_omitted {
        tracing::warn!(
            "no guard: if this program is killed, crashes or hangs, the camera goes on turning at its last rate"
        );
        return Ok(None);
    }
    Ok(Some(find_guard(configuration.guard.program.as_deref())?))
}

/// The guard's program for the boat's port: whatever the boat does at the end of the program, the guard sends
/// neutral.
///
/// # Errors
/// If the guard is not there, and the operator has not said that the run does without it.
pub(super) fn needed_vessel_guard(configuration: &Configuration) -> Result<Option<PathBuf>> {
    match &configuration.vessel {
        Some(vessel) if vessel.settings().path == CommandPath::Link => {}
        _ => return Ok(None),
    }
    if configuration.guard.is_omitted {
        tracing::warn!(
            "no guard: if this program is killed, crashes or hangs, the boat goes on until its own time-out"
        );
        return Ok(None);
    }
    Ok(Some(find_guard(configuration.guard.program.as_deref())?))
}
