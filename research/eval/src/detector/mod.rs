//! Object detectors: pictures to train them on.

mod scene;
mod scenes;

pub(crate) use scenes::{ScenesOptions, write_scenes};
