//! What each command does. One file per command; the reading of logs that several share is in `trial_input`.

pub mod check;
pub mod config;
pub mod demo;
pub mod emulate;
pub mod export;
pub mod law;
pub mod metrics;
pub mod replay;
pub mod run;
pub mod track;

mod trial_input;
