//! Simulated trials and campaigns: one scenario, one law, many seeds.
//!
//! [`simulation`] runs one trial in lock step: world, sensor or [`rendered_camera`], pilot, world. A
//! [`StepObserver`] records or displays the trial. [`world_replay`] renders the pictures of a recorded trial
//! again. [`entry`] is the result of one trial, a line of a campaign's file. [`compare`] pairs the trials of
//! two campaigns by seed.
//!
//! The result of a trial depends only on its scenario, its seed and its settings. Scheduling of trials
//! (threads, processes, order) is not part of this module.

pub mod simulation;

mod camera_output;
pub mod hand_drawn_box;
mod rescue;
mod simulated_operator;

pub mod world_replay;

pub mod frame_source;
pub mod rendered_camera;
pub mod step_observer;

pub mod entry;
pub mod setting_difference;

pub mod statistics;

pub mod compare;

pub use compare::{CampaignComparison, MeanOfAll, PairedMetric, UnpairedMetric};
pub use entry::{CampaignEntry, CampaignSettings};
pub use frame_source::{CapturedFrame, FrameSource};
pub use rendered_camera::RenderedCamera;
pub use setting_difference::SettingDifference;
pub use simulation::{ReportErrors, Simulation};
pub use step_observer::StepObserver;
pub use world_replay::WorldReplay;
