//! The tracker that is measured: this is the one place that knows which it is.

use anyhow::Result;
use barrelman_vision::{FusedConfig, FusedTracker, Tracker};

/// Its settings.
pub(crate) type Config = FusedConfig;

/// Its name in the tables.
pub(crate) const NAME: &str = "fused";

/// What makes a fresh tracker for each clip.
pub(crate) type Factory<'a> = &'a (dyn Fn() -> Box<dyn Tracker> + Sync);

/// A tracker with nothing selected.
///
/// # Errors
/// If a setting lies outside its range.
pub(crate) fn make(config: &Config) -> Result<Box<dyn Tracker>> {
    Ok(Box::new(FusedTracker::new(*config)?))
}
