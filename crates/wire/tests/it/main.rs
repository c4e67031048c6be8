//! Both ends of the Fotokite Pro protocol against transcripts that were written by hand
//! (`fixtures/fotokite-pro/README.md` describes their format), and both ends of the MAVLink gimbal protocol against each other.

// Tests read fixture files, and fail by panicking.
#![allow(clippy::disallowed_methods, clippy::panic, clippy::unwrap_used)]

mod transcript;

mod client;
mod commands;
mod gimbal;
mod hostile;
mod station;
mod telemetry;
