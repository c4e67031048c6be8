//! The demo: a simulated boat that a person steers in the browser.
//!
//! ```text
//! console -> gateway -> inputs, each at a tick -> Drive: trial's Simulation, tick by tick -> snapshots, pictures -> console
//! ```
//! The world of a demo waits for the pilot, so the same inputs at the same ticks give the same drive, bit for
//! bit. (In `run --video sim:` the world follows the clock instead, see [`crate::simulated_source`].)

pub mod session;

pub mod live_drive;
pub mod pacing;

mod first_selection;

mod drill;
pub mod drive_files;
pub mod drive_plan;

mod observers;
mod recording;

pub mod replay;
