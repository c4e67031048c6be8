//! The program: command line, threads, clocks, sockets and files.

pub mod overlay;
