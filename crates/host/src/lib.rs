//! What several programs and crates need of the machine: the monotonic clock, input and output files, and plans of
//! deliberate faults; and the newest-wins slot between two threads.
//!
//! The other crates take time, bytes and files as arguments; the crates that may touch the machine take them from here,
//! so that every clock reading and every output file follows one rule.

pub mod clock;
pub mod fault;
pub mod input;
pub mod output;
pub mod redaction;

pub mod latest;
