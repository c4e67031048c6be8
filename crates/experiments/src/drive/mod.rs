//! A drive: a trial in lock step that a person takes part in.
//!
//! A drive is determined by its setup (scenario, seed, picture size, tracker, law) and by its inputs, each put in before
//! a tick. The clock only decides when the next tick runs. The same setup and the same inputs at the same ticks give the
//! same drive, bit for bit.

mod input;
mod setup;

mod lockstep;

mod encoded_camera;

mod hash;
pub mod motor_schema_shadow;

mod stored;

pub use hash::DriveHash;
pub use input::DriveInput;
pub use lockstep::{Drive, DriveObserver};
pub use setup::{DriveSetup, MAX_S};
pub use stored::{DriveReader, DriveWriter};
