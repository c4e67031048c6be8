//! The commands, one file each. Shared parts: `trial_input` reads trial logs, `summary_table` prints metrics.

mod annotated_film;
pub mod calibrate;
pub mod check;
mod check_gimbal;
mod check_over_http;
mod check_result;
pub mod compare;
pub mod config;
pub mod demo;
mod draw_selection;
pub mod emulate;
pub mod export;
pub mod law;
pub mod library;
pub mod links;
pub mod merge;
pub mod metrics;
pub mod practice;
pub mod render;
pub mod replay;
pub mod replayed_video;
pub mod report;
pub mod run;
pub mod scenarios;
pub mod snapshot;
pub mod stored_video;
pub mod track;
pub mod trials;

mod channel_tables;
mod comparison_table;
mod recorded_sortie;
mod stored_frame;
mod summary_table;
mod track_figures;
mod trial_input;
mod trials_progress;
