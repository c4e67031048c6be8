//! The tracker that is measured: the only file that names its type.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use barrelman_vision::{FusedConfig, FusedTracker, RefinementWeights, Tracker};

use super::clip_sets::recording_of;

/// The tracker's settings.
pub(crate) type TrackerConfig = FusedConfig;

/// The tracker's name in the tables.
pub(crate) const NAME: &str = "fused";

/// Builds a new tracker for the clip of this name.
pub(crate) type TrackerFactory<'a> = &'a (dyn Fn(&str) -> Box<dyn Tracker> + Sync);

/// Weights of the refinement network that were fitted without a recording, by the name of that recording.
#[derive(Debug, Default)]
pub(crate) struct HeldOutWeights(BTreeMap<String, Arc<RefinementWeights>>);

impl HeldOutWeights {
    /// Reads the files `NAME.weights` of a folder. NAME is that of a clip whose recording took no part in the
    /// fit.
    ///
    /// # Errors
    /// If a file cannot be used, or there is none.
    pub(crate) fn load(folder: &Path) -> Result<Self> {
        let mut weights = BTreeMap::new();
        for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "weights") {
                let context = || path.display().to_string();
                let name = path.file_stem().with_context(context)?.to_string_lossy().into_owned();
                let bytes = std::fs::read(&path).with_context(context)?;
                let read = RefinementWeights::from_bytes(&bytes).with_context(context)?;
                weights.insert(recording_of(&name).to_owned(), Arc::new(read));
            }
        }
        ensure!(!weights.is_empty(), "{} holds no file NAME.weights", folder.display());
        Ok(Self(weights))
    }

    /// The weights for a clip: those fitted without its recording, or else the built-in ones.
    fn of_clip(&self, clip: &str) -> Arc<RefinementWeights> {
        self.0.get(recording_of(clip)).map_or_else(RefinementWeights::built_in, Arc::clone)
    }

    /// The names among `clips` for whose recordings there are no weights.
    pub(crate) fn missing<'a>(&self, clips: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
        clips.filter(|clip| !self.0.contains_key(recording_of(clip))).collect()
    }
}

/// A tracker without a selection for a clip.
///
/// # Errors
/// If a setting is out of its range.
pub(crate) fn build_tracker_for(
    config: &TrackerConfig,
    held_out: &HeldOutWeights,
    clip: &str,
) -> Result<Box<dyn Tracker>> {
    Ok(Box::new(FusedTracker::with_weights(*config, held_out.of_clip(clip))?))
}

/// A tracker without a selection.
///
/// # Errors
/// If a setting is out of its range.
pub(crate) fn build_tracker(config: &TrackerConfig) -> Result<Box<dyn Tracker>> {
    Ok(Box::new(FusedTracker::new(*config)?))
}
