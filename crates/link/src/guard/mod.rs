//! The guard: a process of its own that owns the port of a vehicle that keeps its last rate.
//!
//! The program starts the guard with a socket pair as its standard input. The guard outlives whatever ends or
//! stops the program: at the end of the pipe, or after a second of silence, the guard sends zeros and the
//! vehicle's own stop, and ends.

pub mod process;

mod pipe_io;

pub mod gate;

pub mod message;
pub mod pipe;
pub mod watch;

pub use gate::{Gate, GuardedCommand};
