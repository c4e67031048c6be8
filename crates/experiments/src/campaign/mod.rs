//! Campaigns of simulated trials: the plan, the runner, the recordings, and the file of results.
//!
//! A campaign's file is JSON Lines, one trial per line, in the order of the seeds. It does not depend on the
//! number of threads. A file that was cut off holds the first trials of the complete file.

pub mod drive_requests;
pub mod file;
pub mod plan;
pub mod recorded_trial;
pub mod recording;
pub mod runner;
pub mod simulated_time;

pub use plan::{CampaignPlan, Perception, PlantName};
