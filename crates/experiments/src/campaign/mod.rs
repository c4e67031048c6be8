//! Campaigns of simulated trials: what is asked for, who runs it, and the file that it goes to.
//!
//! A campaign's file is JSON Lines, one trial per line, in the order of the seeds: it is the same for any number of
//! threads, and one that was cut off is a beginning of the whole.

pub mod drive_inputs;
pub mod file;
pub mod plan;
pub mod recording;
pub mod runner;

pub use plan::{CampaignPlan, Perception, PlantName};
