//! The program: command line, threads, clocks, sockets and files.

pub mod clock;
pub mod fault;
pub mod video;
