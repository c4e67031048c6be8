//! Tests of logs, metrics, recordings, replay, simulated trials and reports.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]
#![allow(
    clippy::disallowed_methods,
    reason = "a test reads the laboratory's logs, whose folder may be absent"
)]

#[path = "../../../sim/tests/it/trial_world.rs"]
mod trial_world;

mod camera_law;
mod camera_work;
mod excursions;
mod indexed_recordings;
mod laboratory;
mod log_text;
mod lost_trials;
mod perception;
mod replay;
mod simulated_trials;
mod single_message;
mod statistics;
mod summaries;
mod trial_logs;

mod any_bytes;
mod cut_recordings;
mod foreign_recordings;
mod nested_schemas;
mod recorded_logs;
mod round_trips;
mod tables;

mod entries;

mod sorties;

mod reports;
