//! Integration tests of video input and output.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking, and says why it was skipped"
)]

mod damage;
mod decoding;
mod files;
mod live;
mod second_engine;
mod writing;

mod clips;
