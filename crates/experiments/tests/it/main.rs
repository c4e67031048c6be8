//! Integration tests of the experiments.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test fails by panicking, and reads and changes the files that it wrote"
)]

mod drills;
mod drives;
mod scenarios;
mod worlds_without_end;
