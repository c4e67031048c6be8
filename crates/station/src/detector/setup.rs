//! What a detector needs from the start of a run: its model, loaded and tried.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use barrelman_detector::{Detector, Settings};
use barrelman_host::input;
use barrelman_pilot::ClassName;

use crate::config::detector::DetectorConfig;

/// A model, loaded and tried, with the names of its classes.
pub struct DetectorSetup {
    pub(super) model: PathBuf,
    pub(super) detector: Detector,
    pub(super) classes: Vec<ClassName>,
}

impl DetectorSetup {
    /// Loads the model.
    ///
    /// # Errors
    /// If a file cannot be read, or the model cannot be used with its settings.
    pub fn load(config: &DetectorConfig) -> Result<Self> {
        let onnx = input::read(&config.model)?;
        let settings = read_settings(&config.settings)?;
        let classes = settings.classes.iter().map(|name| class_name(name, &config.settings));
        let classes = classes.collect::<Result<_>>()?;
        let detector = Detector::new(&onnx, settings)
            .with_context(|| format!("{} with {}", config.model.display(), config.settings.display()))?;
        Ok(Self { model: config.model.clone(), detector, classes })
    }

    /// The names of the classes, in words.
    pub fn classes(&self) -> String {
        self.classes.iter().map(ClassName::as_str).collect::<Vec<_>>().join(", ")
    }
}

fn read_settings(path: &Path) -> Result<Settings> {
    let text = input::read(path).with_context(|| {
        format!(
            "{}: the settings of the model; write them, or name the file (detector.settings)",
            path.display()
        )
    })?;
    let text = String::from_utf8(text).with_context(|| format!("{} is no text", path.display()))?;
    Settings::from_toml(&text).with_context(|| path.display().to_string())
}

fn class_name(name: &str, path: &Path) -> Result<ClassName> {
    let Some(name) = ClassName::new(name) else {
        bail!(
            "{}: the class {name:?} cannot be shown: give a name of 1 to {} bytes in one line",
            path.display(),
            ClassName::MAX_BYTES
        )
    };
    Ok(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(model: &str, settings: &str) -> String {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/detector"));
        let config = DetectorConfig { model: folder.join(model), settings: folder.join(settings) };
        match DetectorSetup::load(&config) {
            Ok(_) => panic!("{model} with {settings} is usable"),
            Err(error) => format!("{error:#}"),
        }
    }

    #[test]
    fn what_cannot_be_used_is_named_with_its_file() {
        let cases = [
            ("none.onnx", "detector.toml", "none.onnx"),
            ("red-yolo.onnx", "none.toml", "write them, or name the file (detector.settings)"),
            ("red-yolo.onnx", "red-yolo.onnx", "red-yolo.onnx is no text"),
            ("red-yolo.onnx", "README.md", "README.md: the settings cannot be read"),
            ("detector.toml", "detector.toml", "not a model in ONNX"),
            ("red-yolo.onnx", "red-detr.toml", "correct [output] and classes"),
        ];
        for (model, settings, expected) in cases {
            let text = error(model, settings);
            assert!(text.contains(expected), "{model} with {settings}: {text}");
        }
    }

    #[test]
    fn a_class_must_have_a_name_that_can_be_shown() {
        for name in ["", "a\nb", "a name of more than 24 bytes"] {
            let text = class_name(name, Path::new("detector.toml")).unwrap_err().to_string();
            assert!(text.starts_with("detector.toml: the class"), "{text}");
        }
    }
}
