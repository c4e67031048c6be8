//! The log of one trial.

use crate::metrics::GuidanceMetrics;
use barrelman_control::Region;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{CameraCommand, ImagePoint, PictureSize};

use super::water_log::WaterLog;
use crate::target_in_picture::JudgedTrack;

/// One row: the state at one time of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRow {
    /// Time since the trial's first row, s.
    pub time_s: f64,
    /// Position of the target as localised, `None` while the track was lost; in a simulated trial in pixels
    /// the true position, also out of the picture.
    pub position: Option<ImagePoint>,
    /// The command as it was sent: pan positive to the right, tilt upwards; `None` where the log does not
    /// contain it.
    pub command: Option<CameraCommand>,
}

/// The log of one trial.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialLog {
    /// The rows, in the order of time.
    pub rows: Vec<LogRow>,
    /// Duration of the last row, s. That of every other row is the time to the next.
    pub last_row_duration_s: f64,
    /// Size of the frame, whose width and height the region is a share of.
    pub frame: PictureSize,
    /// Size of the picture within the frame: smaller where it is letter-boxed.
    pub picture: PictureSize,
    /// Whether the log records that the track was lost.
    pub records_track_loss: bool,
    /// The ground truth of each row, where the trial was simulated.
    pub truth: Option<Vec<RowTruth>>,
    /// Number of selections, in a simulated trial in pixels. The positions of its rows are the truth; what
    /// the tracker said is in [`RowTruth::track`].
    pub selections: Option<usize>,
    /// How the boat went to a person, in a simulated trial with guidance.
    pub guidance: Option<GuidanceMetrics>,
    /// The way of a boat that was commanded, in a recording.
    pub water: Option<WaterLog>,
}

/// The ground truth at a row of a simulated trial. World coordinates: x to the right and y ahead of the first
/// view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowTruth {
    /// Whether the target was out of the picture.
    pub out_of_picture: bool,
    /// Achieved rates of the camera's axes, rad/s: pan, tilt; `None` in a recording.
    pub achieved_rates: Option<(f64, f64)>,
    /// What the tracker said about the row's picture, in a trial in pixels.
    pub track: Option<JudgedTrack>,
    /// Position of the target in the world, m: x, y.
    pub target_m: (f64, f64),
    /// Position of the camera in the world, m: x, y.
    pub camera_m: (f64, f64),
}

impl TrialLog {
    /// The region of this trial for region shares.
    pub fn region(&self, shares: RegionShares) -> Region {
        Region::from_shares(shares, self.frame)
    }

    /// Duration of a row, s: the time to the next row.
    pub fn row_duration_s(&self, row: usize) -> f64 {
        match (self.rows.get(row), self.rows.get(row + 1)) {
            (Some(this), Some(next)) => (next.time_s - this.time_s).max(0.0),
            _ => self.last_row_duration_s,
        }
    }

    /// Duration of the trial, s: from the first row to the end of the last.
    pub fn duration_s(&self) -> f64 {
        match (self.rows.first(), self.rows.last()) {
            (Some(first), Some(last)) => last.time_s - first.time_s + self.last_row_duration_s,
            _ => 0.0,
        }
    }
}
