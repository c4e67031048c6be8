//! Experiments: scenario files, campaigns of simulated trials, drives, and the choice of laws and trackers.
//!
//! The program and the evaluation share this crate. It turns what a user names (a scenario, a law, a tracker,
//! a seed) into a world, a pilot and a trial, and stores the results. The crate reads no clock and opens no
//! socket; files go through `barrelman_host`.

pub mod calibration;
pub mod campaign;
pub mod drill;
pub mod drive;

pub mod scenario;

pub mod law_choice;
pub mod tracker_choice;

pub mod world_url;

pub mod toml_message;

pub mod render_threads;
