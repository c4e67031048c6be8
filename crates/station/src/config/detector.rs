//! The detector in the configuration.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name of the settings beside a model.
const SETTINGS: &str = "detector.toml";

/// A detector of your own, which says what the numbered objects are.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DetectorSection {
    /// The model, a file in ONNX; without a model nothing is detected. A relative path starts in the current
    /// folder.
    #[schemars(example = "model.onnx")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<PathBuf>,
    /// What the model takes and answers; default: `detector.toml` beside the model.
    #[schemars(example = "detector.toml")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settings: Option<PathBuf>,
}

/// The files of a detector.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DetectorConfig {
    /// The model.
    pub model: PathBuf,
    /// What the model takes and answers.
    pub settings: PathBuf,
}

impl DetectorSection {
    /// The files; `None`: nothing is detected.
    pub(super) fn resolve(&self) -> Option<DetectorConfig> {
        let model = self.model.clone()?;
        let settings = self.settings.clone().unwrap_or_else(|| model.with_file_name(SETTINGS));
        Some(DetectorConfig { model, settings })
    }

    /// A complete section.
    pub(super) fn from_config(config: Option<&DetectorConfig>) -> Self {
        let (model, settings) = config.map(|config| (config.model.clone(), config.settings.clone())).unzip();
        Self { model, settings }
    }
}
