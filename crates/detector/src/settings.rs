//! What a model takes and answers: the file `detector.toml` beside it.

use serde::Deserialize;

use crate::error::ModelError;

/// Sides of an input, pixels.
const SIDES: core::ops::RangeInclusive<usize> = 8..=4096;
/// Most classes.
const MAX_CLASSES: usize = 1000;

/// What a model takes and answers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The names of the classes, in the model's order.
    pub classes: Vec<String>,
    /// What the model takes.
    pub input: InputSettings,
    /// What the model answers.
    pub output: OutputSettings,
    /// Which boxes are objects.
    #[serde(default)]
    pub thresholds: Thresholds,
}

/// What a model takes: one picture, as 32-bit floating-point numbers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputSettings {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Order of the axes.
    #[serde(default)]
    pub layout: InputLayout,
    /// Order of the channels.
    #[serde(default)]
    pub channels: ChannelOrder,
    /// Factor of the samples, which are 0 to 255.
    #[serde(default = "InputSettings::unit_scale")]
    pub scale: f32,
    /// What is subtracted after that, in the order of the channels.
    #[serde(default)]
    pub mean: [f32; 3],
    /// What the difference is divided by, in the order of the channels.
    #[serde(default = "InputSettings::unit_deviation")]
    pub std: [f32; 3],
    /// Whether the picture keeps its aspect ratio, in the middle of grey bars, or fills the input.
    #[serde(default = "InputSettings::letterbox")]
    pub letterbox: bool,
}

impl InputSettings {
    const fn unit_scale() -> f32 {
        1.0 / 255.0
    }

    const fn unit_deviation() -> [f32; 3] {
        [1.0; 3]
    }

    const fn letterbox() -> bool {
        true
    }

    /// The shape of the input.
    pub(crate) const fn shape(&self) -> [usize; 4] {
        match self.layout {
            InputLayout::Nchw => [1, 3, self.height, self.width],
            InputLayout::Nhwc => [1, self.height, self.width, 3],
        }
    }
}

/// Order of an input's axes: N pictures, C channels, H rows, W columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InputLayout {
    /// A plane for each channel.
    #[default]
    Nchw,
    /// Pixel by pixel.
    Nhwc,
}

/// Order of an input's channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ChannelOrder {
    /// Red first.
    #[default]
    Rgb,
    /// Blue first.
    Bgr,
}

/// What a model answers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "format", rename_all = "lowercase", deny_unknown_fields)]
pub enum OutputSettings {
    /// One output: the centre, width and height of each of N boxes, then its scores.
    Yolo {
        /// Order of the axes.
        #[serde(default)]
        order: OutputOrder,
        /// Whether a score that there is an object at all precedes those of the classes.
        #[serde(default)]
        objectness: bool,
        /// Unit of the boxes.
        #[serde(default)]
        boxes: BoxUnit,
        /// What makes scores of what the model answers.
        #[serde(default)]
        scores: ScoreFunction,
    },
    /// Two outputs: logits [1, N, C] and boxes [1, N, 4], centre, width and height as shares of the input's.
    Detr {
        /// What makes scores of the logits: with `softmax` there is one logit more, of no object.
        #[serde(default = "OutputSettings::softmax")]
        scores: ScoreFunction,
    },
}

impl OutputSettings {
    const fn softmax() -> ScoreFunction {
        ScoreFunction::Softmax
    }
}

/// Order of the axes of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputOrder {
    /// [1, 4 + C, N].
    #[default]
    ValuesFirst,
    /// [1, N, 4 + C].
    BoxesFirst,
}

/// Unit of the coordinates of boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BoxUnit {
    /// Pixels of the input.
    #[default]
    Pixels,
    /// Shares of the input's width and height.
    Shares,
}

/// What makes scores of what a model answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScoreFunction {
    /// Nothing: the model answers scores.
    #[default]
    None,
    /// The logistic function, of each value.
    Sigmoid,
    /// The softmax of all classes.
    Softmax,
}

/// Which boxes are objects.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Thresholds {
    /// Least score, 0 to 1.
    pub score: f32,
    /// Largest IoU of two objects of a class: of boxes that overlap more, that of the highest score stays.
    pub iou: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { score: 0.5, iou: 0.5 }
    }
}

impl Settings {
    /// The settings of a file.
    ///
    /// # Errors
    /// If a key is not known, or a value is out of its range.
    pub fn from_toml(text: &str) -> Result<Self, ModelError> {
        let settings: Self =
            toml::from_str(text).map_err(|error| ModelError::UnreadableSettings(error.to_string()))?;
        settings.check()?;
        Ok(settings)
    }

    fn check(&self) -> Result<(), ModelError> {
        let setting = |key, value: String, wanted| Err(ModelError::Setting { key, value, wanted });
        let InputSettings { width, height, scale, mean, std, .. } = &self.input;
        for (key, side) in [("input.width", width), ("input.height", height)] {
            if !SIDES.contains(side) {
                return setting(key, side.to_string(), "8 to 4096 pixels");
            }
        }
        if !scale.is_finite() || *scale == 0.0 {
            return setting("input.scale", scale.to_string(), "a number other than 0");
        }
        if mean.iter().any(|value| !value.is_finite()) {
            return setting("input.mean", format!("{mean:?}"), "three numbers");
        }
        if std.iter().any(|value| !value.is_finite() || *value == 0.0) {
            return setting("input.std", format!("{std:?}"), "three numbers other than 0");
        }
        if self.classes.is_empty() || self.classes.len() > MAX_CLASSES {
            return setting("classes", format!("{} names", self.classes.len()), "1 to 1000 names");
        }
        if matches!(self.output, OutputSettings::Yolo { scores: ScoreFunction::Softmax, .. }) {
            return setting("output.scores", "\"softmax\"".to_owned(), "\"none\" or \"sigmoid\" for yolo");
        }
        let Thresholds { score, iou } = self.thresholds;
        if !(0.0..=1.0).contains(&score) {
            return setting("thresholds.score", score.to_string(), "0 to 1");
        }
        if !(0.0..=1.0).contains(&iou) {
            return setting("thresholds.iou", iou.to_string(), "0 to 1");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST: &str =
        "classes = [\"boat\"]\n[input]\nwidth = 64\nheight = 48\n[output]\nformat = \"yolo\"\n";

    #[test]
    fn the_least_settings_are_those_of_a_usual_export() {
        let settings = Settings::from_toml(LEAST).unwrap();
        assert_eq!(settings.input.shape(), [1, 3, 48, 64]);
        assert_eq!((settings.input.scale, settings.input.letterbox), (1.0 / 255.0, true));
        assert_eq!(settings.thresholds, Thresholds { score: 0.5, iou: 0.5 });
    }

    #[test]
    fn the_example_is_usable_and_its_comments_are_the_defaults() {
        let example = include_str!("../../../config/detector.example.toml");
        let settings = Settings::from_toml(example).unwrap();
        let is_key = |line: &str| {
            line.split_once(" = ").is_some_and(|(key, _)| key.chars().all(|c| c.is_ascii_lowercase()))
        };
        let stated: Vec<_> = example
            .lines()
            .map(|line| line.strip_prefix("# ").filter(|key| is_key(key)).unwrap_or(line))
            .collect();
        let stated = Settings::from_toml(&stated.join("\n")).unwrap();
        assert_eq!(stated, settings);
        assert_eq!(settings.classes, ["boat", "person"]);
    }

    #[test]
    fn the_settings_of_the_documentation_are_usable() {
        let page = include_str!("../../../docs/integrations.md");
        let lines: Vec<_> = page.lines().map(|line| line.strip_prefix("    ").unwrap_or_default()).collect();
        let blocks: Vec<_> = lines.split(|line| line.is_empty()).map(|block| block.join("\n")).collect();
        let settings = blocks.iter().filter(|block| block.starts_with("classes = "));
        let usable: Vec<_> = settings.map(|block| Settings::from_toml(block).unwrap()).collect();
        let [yolo, detr] = &usable[..] else { panic!("{usable:?}") };
        assert!(matches!(yolo.output, OutputSettings::Yolo { objectness: false, .. }));
        assert!(matches!(detr.output, OutputSettings::Detr { scores: ScoreFunction::Softmax }));
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        let cases = [
            ("width = 64", "width = 4", "input.width = 4 cannot be used: give 8 to 4096 pixels"),
            ("height = 48", "height = 48\nscale = 0.0", "input.scale = 0"),
            ("height = 48", "height = 48\nmean = [nan, 0.0, 0.0]", "input.mean = [NaN"),
            ("height = 48", "height = 48\nstd = [1.0, 0.0, 1.0]", "input.std"),
            ("\"boat\"", "", "classes = 0 names"),
            ("\"yolo\"", "\"yolo\"\nscores = \"softmax\"", "output.scores"),
            ("\"yolo\"", "\"yolo\"\n[thresholds]\nscore = 2.0", "thresholds.score = 2"),
            ("\"yolo\"", "\"yolo\"\n[thresholds]\niou = -0.1", "thresholds.iou = -0.1"),
            ("width", "widht", "unknown field `widht`"),
            ("\"yolo\"", "\"ssd\"", "unknown variant `ssd`"),
            ("\"yolo\"", "\"detr\"\nobjectness = true", "unknown field `objectness`"),
        ];
        for (from, to, expected) in cases {
            let error = Settings::from_toml(&LEAST.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.contains(expected), "{to}: {error}");
        }
    }
}
