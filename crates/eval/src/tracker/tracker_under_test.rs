//! The tracker that is measured: the only file that names its type.

use anyhow::Result;
use barrelman_vision::{FusedConfig, FusedTracker, Tracker};

/// The tracker's settings.
pub(crate) type TrackerConfig = FusedConfig;

/// The tracker's name in the tables.
pub(crate) const NAME: &str = "fused";

/// Builds a new tracker for each clip.
pub(crate) type TrackerFactory<'a> = &'a (dyn Fn() -> Box<dyn Tracker> + Sync);

/// A tracker without a selection.
///
/// # Errors
/// If a setting is out of its range.
pub(crate) fn build_tracker(config: &TrackerConfig) -> Result<Box<dyn Tracker>> {
    Ok(Box::new(FusedTracker::new(*config)?))
}
