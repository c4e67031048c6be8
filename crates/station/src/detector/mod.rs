//! The operator's own detector: a model in ONNX that says what objects are, and finds others.
//!
//! ```text
//! run loop --newest frame--> slot -> thread detector: model -> event -> run loop -> Pilot::step
//! ```
//! What must not be here: a request, a wait of the run loop, a queue of frames.

mod input;
mod setup;
mod thread;

pub use input::DetectorInput;
pub use setup::DetectorSetup;
pub use thread::DetectorThread;
