//! Refinement: a second look at the target, which is independent of the correlation filter.
//!
//! An upright window around the box is sampled on a grid of cells ([`window`]): brightness, gradients,
//! colours, what moved with the target and what with the background ([`motion`]), and what the window showed
//! at the selection ([`memory`]). A small convolutional network ([`network`]) reads the cells. It answers
//! with the box, the error that it expects of each edge, and the probability that the box is right.
//!
//! The channels are relative to the target and its surroundings, so that the network does not know what kind
//! of object it looks at. Its weights were fitted to labelled recordings and simulated scenes
//! (`research/training/train_refinement.py`).

mod network;
mod refined_box;
mod weights;

mod convolution;
mod dense_layer;

mod memory;
mod motion;
mod window;

pub(crate) use memory::WindowMemory;
pub(crate) use motion::MotionReferences;
pub(crate) use network::RefinementNetwork;
pub(crate) use refined_box::RefinedBox;
pub use weights::{RefinementWeights, RefinementWeightsError};
pub use window::{MEASUREMENTS, RefinementWindow, WINDOW_CHANNELS, WINDOW_SIDE_CELLS};
pub(crate) use window::{Measurements, WindowContext};
