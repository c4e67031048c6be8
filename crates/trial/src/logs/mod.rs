//! Logs of trials: where the target was and what the camera was told, over time.
//!
//! [`TrialLog`] is what metrics and laws work on, wherever it came from: the laboratory's CSV
//! ([`laboratory`]), a CSV that was exported from a recording ([`exported`]), or a recording itself
//! ([`recorded`]).

pub mod exported;
pub mod laboratory;
pub mod recorded;

use barrelman_control::Region;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{ImagePoint, PictureSize, VehicleRates};

/// One row: a moment of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRow {
    /// Seconds since the trial's first row.
    pub time_s: f64,
    /// Where the target was; `None` while the track was lost.
    pub position: Option<ImagePoint>,
    /// What the camera was told, in the vehicle's own signs; `None` where the log does not say.
    pub rates: Option<VehicleRates>,
}

/// One trial.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialLog {
    /// Its rows, in time.
    pub rows: Vec<LogRow>,
    /// Seconds that the last row stands for: there is no next one to tell.
    pub last_row_s: f64,
    /// The frame that the region is a share of.
    pub frame: PictureSize,
    /// The picture in that frame: a letter-boxed one is smaller.
    pub picture: PictureSize,
    /// Whether the log can tell that the track was lost.
    pub knows_lost: bool,
    /// What was true at each row, where the trial was simulated.
    pub truth: Option<Vec<RowTruth>>,
}

/// What was true at a row of a simulated trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowTruth {
    /// Whether the target was out of the picture.
    pub out_of_picture: bool,
    /// The rates that the camera's axes had, rad/s: pan, tilt; `None` in a recording.
    pub achieved: Option<(f64, f64)>,
    /// Where the target was in the world, metres: x to the right and y ahead of the first view.
    pub target_m: (f64, f64),
    /// Where the camera was, likewise.
    pub camera_m: (f64, f64),
}

impl TrialLog {
    /// The region of this trial for these shares.
    pub fn region(&self, shares: RegionShares) -> Region {
        Region::from_shares(shares, self.frame)
    }

    /// Seconds from a row to the next.
    pub fn step_s(&self, row: usize) -> f64 {
        match (self.rows.get(row), self.rows.get(row + 1)) {
            (Some(this), Some(next)) => (next.time_s - this.time_s).max(0.0),
            _ => self.last_row_s,
        }
    }

    /// Seconds from the first row to the end of the last.
    pub fn duration_s(&self) -> f64 {
        match (self.rows.first(), self.rows.last()) {
            (Some(first), Some(last)) => last.time_s - first.time_s + self.last_row_s,
            _ => 0.0,
        }
    }
}

/// A log cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LogError {
    /// It has no rows.
    #[error("the log has no rows")]
    Empty,
    /// It begins like none of the logs that are known.
    #[error(
        "this is no trial log: it begins with {found:?}; expected the laboratory's x_val,y_val,pitch,yaw,val,time, \
         a CSV with the columns time_s,x,y,pitch_rate,yaw_rate, or an MCAP recording"
    )]
    UnknownHeader {
        /// How it begins.
        found: String,
    },
    /// A row has another number of fields than the first.
    #[error("line {line}: {found} fields where the first row has {expected}")]
    FieldCount {
        /// Line in the file, from 1.
        line: usize,
        /// Fields in it.
        found: usize,
        /// Fields in the first row.
        expected: usize,
    },
    /// A field is not a number.
    #[error("line {line}: {column} is {found:?}, which is not a number")]
    NotANumber {
        /// Line in the file, from 1.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// What stands there.
        found: String,
    },
    /// A side of the picture is no whole number of pixels.
    #[error("line {line}: {column} is {found}, which is no number of pixels from 1 to 65536")]
    NotASize {
        /// Line in the file, from 1.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// What stands there.
        found: f64,
    },
    /// The times run backwards.
    #[error("line {line}: the time {time_s} s lies before that of the row above")]
    TimeRunsBack {
        /// Line in the file, from 1.
        line: usize,
        /// The time.
        time_s: f64,
    },
}

/// A log as far as it could be read.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadLog {
    /// The rows that are whole.
    pub log: TrialLog,
    /// The line (from 1) in which the file was cut, if it was: a last line without its end.
    pub cut_at_line: Option<usize>,
}

/// Reads a text log of either kind.
///
/// # Errors
/// [`LogError`] where it is none, or a row of it cannot be understood.
pub fn read_text(text: &str) -> Result<ReadLog, LogError> {
    if text.starts_with(laboratory::HEADER) {
        laboratory::read(text)
    } else if exported::is_one(text) {
        exported::read(text)
    } else if text.trim().is_empty() {
        Err(LogError::Empty)
    } else {
        let found = text.lines().next().unwrap_or_default().chars().take(60).collect();
        Err(LogError::UnknownHeader { found })
    }
}

/// Lines with their numbers (from 1), and the number of a last one that has no end.
fn whole_lines(text: &str) -> (Vec<(usize, &str)>, Option<usize>) {
    let mut lines: Vec<(usize, &str)> =
        text.split_inclusive('\n').enumerate().map(|(index, line)| (index + 1, line)).collect();
    let cut = match lines.last() {
        Some((number, line)) if !line.ends_with('\n') => Some(*number),
        _ => None,
    };
    if cut.is_some() {
        lines.pop();
    }
    (lines, cut)
}

fn number(text: &str, line: usize, column: &'static str) -> Result<f64, LogError> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| LogError::NotANumber {
        line,
        column,
        found: text.trim().to_owned(),
    })
}

fn optional_number(text: &str, line: usize, column: &'static str) -> Result<Option<f64>, LogError> {
    if text.trim().is_empty() { Ok(None) } else { number(text, line, column).map(Some) }
}
