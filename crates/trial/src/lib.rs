//! Trials: recordings and their format, trial logs, metrics, simulated trials and campaigns, replay, reports.
//!
//! What must not be here: files and sockets (readers and writers work on `Read` and `Write`), clocks, and any
//! decision that a live run does not make as well: a replay calls the same pilot.
#![forbid(unsafe_code)]

pub mod target_in_picture;

pub mod csv_row;
pub mod logs;

pub mod metrics;

pub mod camera_work;
pub mod campaign;
pub mod law;
pub mod records;
pub mod replay;
pub mod shadow;
pub mod sortie;
pub mod work_step;

pub mod report;
