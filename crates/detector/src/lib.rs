//! Objects in a video frame, by a model in ONNX that the operator brings.
//!
//! ```text
//! picture -> preparation (size, colours, scale) -> model -> decoding -> non-maximum suppression -> objects
//! ```
//! [`Settings`] say what the model takes and answers. A model that does not fit them is refused as it is
//! loaded, with one inference of zeros. Numbers that a model answers later are bounded: what is not finite is
//! left out and counted. Not handled: several inputs, weights outside of the file, masks, key points,
//! tracking.

mod decode;
mod error;
mod model;
mod preparation;
mod settings;
mod suppression;

pub use error::ModelError;
pub use model::Detector;
pub use settings::{BoxUnit, ChannelOrder, InputLayout, OutputOrder, ScoreFunction, Settings};

use barrelman_vocab::PixelBox;

/// Most objects of one picture.
pub const MAX_OBJECTS: usize = 32;

/// An object that the model found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Object {
    /// The box, pixels of the picture, within it.
    pub bounds: PixelBox,
    /// Index of the class in [`Settings::classes`].
    pub class: usize,
    /// The score, 0 to 1.
    pub score: f32,
}

/// The answer for one picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Objects {
    /// The objects, the highest score first, at most [`MAX_OBJECTS`].
    pub found: Vec<Object>,
    /// Boxes that were left out because a number of theirs is not finite.
    pub not_finite: usize,
}
