//! Logs of trials: positions of the target and camera commands over time.
//!
//! Metrics and laws work on a [`TrialLog`]. It is read from the laboratory's CSV ([`laboratory`]), from a CSV
//! exported from a recording ([`exported`]), or from a recording itself ([`recorded`]).

mod trial_log;

mod water_log;

mod text;

pub mod exported;
pub mod laboratory;
pub mod recorded;

mod csv;
mod log_error;

pub use csv::ParsedLog;
pub use log_error::LogError;
pub use text::read_text;
pub use trial_log::{LogRow, RowTruth, TrialLog};
pub use water_log::{MarkOnWater, WaterLog};
