//! Trials as figures and a page: the paper's figures (`biswas2017`) redone from logs and metrics.
//!
//! [`ReportedTrial`] is what goes in, [`Report`] what comes out: one self-contained HTML page ([`Report::page`]) and
//! each figure by itself as SVG ([`Report::figures`]). Both are text; nothing here opens a file. Every text that comes
//! from outside (names of files and scenarios) goes through [`text::escaped`].
//!
//! Figures of one trial: P over time with the boundary at 1 and every excursion with its h and b ([`p_over_time`]); the
//! commands in the vehicle's own signs ([`commands`]); the path in the picture, image coordinates, with the region and
//! the sectors ([`picture_path`]); where the trial was simulated, the path in the world from above ([`arena_path`]).
//! Figures of many: the sensitivities ([`sensitivity`]) and, in the list of trials, a small P over time
//! ([`sparkline`]).
//!
//! Not handled: zooming, and more than one region in one report.

pub mod sets;

pub mod page;

pub mod figure;

pub mod arena_path;
pub mod commands;
pub mod p_over_time;
pub mod picture_path;
pub mod sensitivity;
pub mod sparkline;

mod tables;
mod verdict;

mod canvas;
mod line;
mod scale;
mod style;
pub mod text;
mod time_axis;

pub use figure::Figure;
pub use page::Report;
pub use sets::{SetKind, TrialSet};

use barrelman_control::Region;

use crate::logs::TrialLog;
use crate::metrics::TrialEntry;

/// A trial that is reported.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportedTrial {
    /// Its name, arena and metrics.
    pub entry: TrialEntry,
    /// Which trials it is to be counted with.
    pub set: TrialSet,
    /// How it went, with the region that P is of; `None` where its metrics alone are known.
    pub course: Option<Course>,
}

/// How a trial went.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Its rows.
    pub log: TrialLog,
    /// The region that P is of.
    pub region: Region,
    /// P as it would have been with the schema, row by row, where another law servoed.
    pub shadow: Option<Vec<Option<f64>>>,
}
