//! What each command does. One file per command; the reading of logs that several share is in `trial_input`.

pub mod check;
pub mod compare;
pub mod config;
pub mod demo;
pub mod emulate;
pub mod export;
pub mod law;
pub mod merge;
pub mod metrics;
pub mod practice;
pub mod render;
pub mod replay;
pub mod report;
pub mod run;
pub mod scenarios;
pub mod stored_video;
pub mod track;
pub mod trials;

mod channel_tables;
mod summary_table;
mod trial_input;
