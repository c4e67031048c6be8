//! A drive: a trial in lock step in which a person steers.
//!
//! The setup (scenario, seed, picture size, tracker, law) and the inputs, each applied before a tick,
//! determine a drive. The clock only decides when the next tick runs. The same setup with the same inputs at
//! the same ticks gives the same drive, bit for bit.

mod setup;

mod lockstep;

mod encoded_camera;

mod hash;

mod stored;

pub use hash::DriveHasher;
pub(crate) use lockstep::simulated_vessel;
pub use lockstep::{Drive, DriveObserver};
pub use setup::DriveSetup;
pub use stored::{DriveWriter, StoredDrive};
