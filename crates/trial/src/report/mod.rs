//! Reports of trials: the paper's figures (`biswas2017`) drawn from logs and metrics.
//!
//! A [`Report`] of [`ReportedTrial`]s gives one self-contained HTML page ([`Report::page`]) and each figure
//! as SVG ([`Report::figures`]), both as text: nothing here opens a file. Every text from outside (names of
//! files and scenarios) is escaped.
//!
//! Figures of one trial: P over time with the boundary at 1 and the h and b of every excursion
//! ([`p_over_time`]); the commands, pan and tilt ([`commands`]); the path in the picture with the region and
//! the sectors ([`picture_path`]); for a simulated trial, the path in the world from above ([`world_path`]);
//! where a boat was commanded, the map of the water ([`water_map`]). Figures of several trials: the
//! sensitivities, and a sparkline of P for each trial in the list.
//!
//! Not supported: zooming, and more than one region in a report.

mod page;

mod natural_order;

mod reported_trial;
mod trial_group;

pub mod figure;

pub mod commands;
pub mod p_over_time;
pub mod picture_path;
mod sensitivity;
mod sparkline;
pub mod water_map;
pub mod world_path;

mod sortie;

mod claims;
mod columns;
mod tables;

mod canvas;
mod path_data;
mod plan_view;
mod scale;
mod style;
mod text;
mod time_axis;

pub use figure::Figure;
pub use page::Report;
pub use reported_trial::{ReportedTrial, SetKind, TrialSet, TrialTrace};
