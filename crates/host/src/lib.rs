//! Access to the machine for the crates that may have it: the monotonic clock, input and output files,
//! threads, plans of deliberate faults, and the newest-wins slot between two threads.
//!
//! The other crates take time, bytes and files as arguments. The crates with access to the machine use this
//! crate, so that every clock reading and every output file follows one rule.

pub mod absence;
pub mod clock;
pub mod fault;
pub mod fault_lines;
pub mod input;
pub mod output;
pub mod program;
pub mod random;
pub mod redaction;
pub mod state_folder;
pub mod suspend;
pub mod threads;

pub mod latest;
