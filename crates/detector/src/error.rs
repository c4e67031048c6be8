//! Why a model cannot be used.

/// A model, or its settings, cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// The settings are not TOML of the known form.
    #[error("the settings cannot be read: {0}")]
    UnreadableSettings(String),
    /// A setting is out of its range.
    #[error("{key} = {value} cannot be used: give {wanted}")]
    Setting {
        /// The key.
        key: &'static str,
        /// What it is.
        value: String,
        /// What it may be.
        wanted: &'static str,
    },
    /// The file is not a model in ONNX.
    #[error(
        "the file is not a model in ONNX that can be read ({0}): export it again, with its weights in one file"
    )]
    NotOnnx(String),
    /// The model has another number of inputs.
    #[error("the model has {0} inputs: give a model that takes one picture")]
    Inputs(usize),
    /// The model declares another input.
    #[error(
        "the model takes an input of {declared}, but [input] of the settings makes one of {made}: correct width, height and layout"
    )]
    InputShape {
        /// As in the model.
        declared: String,
        /// By the settings.
        made: String,
    },
    /// The model computes something that is not supported, or that does not fit its input.
    #[error(
        "the model cannot be computed ({0}): export it again, with a fixed input of 32-bit floating-point numbers and without the operator that is named"
    )]
    NotComputable(String),
    /// The model's outputs do not fit the settings.
    #[error("the model answers {answered}, but the settings make {expected}: correct [output] and classes")]
    Outputs {
        /// Shapes of the outputs.
        answered: String,
        /// What the settings need.
        expected: String,
    },
    /// The model answers no numbers.
    #[error(
        "each of the {0} boxes that the model answers has a number that is not finite: correct scale, mean and std of [input], or train the model again"
    )]
    NotFinite(usize),
    /// The model answers too many boxes.
    #[error(
        "the model answers {boxes} boxes for a picture, more than {most}: export it again, with a smaller input"
    )]
    TooManyBoxes {
        /// How many.
        boxes: usize,
        /// How many are allowed.
        most: usize,
    },
}
