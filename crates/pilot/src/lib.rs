//! The step that joins localisation and control: one input in, one [`Outcome`] out.
//!
//! Live, simulated and replayed runs call the same [`Pilot::step`]; only who supplies the input and who takes
//! the outcome differs. It is total: it cannot fail, block, or depend on anything but its arguments and its own
//! state, and it allocates nothing once it has seen a few frames.
//!
//! What must not be here: clocks, threads, files, vehicle signs, protocols, and a second place that decides
//! whether the camera may move: that is [`safety`] alone.
#![forbid(unsafe_code)]

pub mod step;

pub mod safety;

pub mod input;
pub mod outcome;

pub use barrelman_control::LawSettings;
pub use input::Input;
pub use outcome::{Advice, Mode, Notice, Outcome};
pub use step::{Pilot, PilotSettings};
