//! A model under test.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use barrelman_detector::{Detector, Object, Settings};
use barrelman_host::input;
use barrelman_vocab::Picture;

use crate::tracker::tracker_run::process_cpu_time;

/// The lowest threshold of the tables; the model answers all objects above it.
pub(super) const LEAST_SCORE: f32 = 0.1;

/// A model, and the time that it took.
pub(super) struct MeasuredDetector {
    detector: Detector,
    /// The threshold of the settings.
    pub(super) score: f32,
    /// CPU time of each picture, milliseconds.
    pub(super) times_ms: Vec<f64>,
}

impl MeasuredDetector {
    /// Loads a model; its settings are beside it, with the ending `toml`, unless they are named.
    ///
    /// # Errors
    /// If a file cannot be read, or the model does not fit its settings.
    pub(super) fn load(model: &Path, settings: Option<&PathBuf>) -> Result<Self> {
        let path = settings.cloned().unwrap_or_else(|| model.with_extension("toml"));
        let text = String::from_utf8(input::read(&path)?).with_context(|| path.display().to_string())?;
        let mut settings = Settings::from_toml(&text).with_context(|| path.display().to_string())?;
        let score = settings.thresholds.score;
        settings.thresholds.score = score.min(LEAST_SCORE);
        let detector = Detector::new(&input::read(model)?, settings)
            .with_context(|| format!("{} with {}", model.display(), path.display()))?;
        Ok(Self { detector, score, times_ms: Vec::new() })
    }

    /// The index of a class.
    pub(super) fn class(&self, name: &str) -> Option<usize> {
        self.detector.settings().classes.iter().position(|class| class == name)
    }

    /// Finds the objects in a picture, also those below the settings' threshold.
    ///
    /// # Errors
    /// If the model cannot be computed.
    pub(super) fn detect(&mut self, picture: &Picture) -> Result<Vec<Object>> {
        let before = process_cpu_time();
        let objects = self.detector.detect(picture)?;
        self.times_ms.push((process_cpu_time() - before).as_secs_f64() * 1e3);
        Ok(objects.found)
    }
}
