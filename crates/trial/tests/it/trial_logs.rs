//! Small logs for tests of metrics: rows of 0.5 s, a circular region with a radius of 100 px.

use barrelman_control::Region;
use barrelman_trial::logs::{LogRow, TrialLog};
use barrelman_trial::metrics::{TrialMetrics, measure};
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, PictureSize, VehicleRates};

pub(crate) const REGION: Region = Region { a_px: 100.0, b_px: 100.0 };
pub(crate) const PICTURE: PictureSize = PictureSize::new(1000, 800);

pub(crate) fn rates(yaw: f64, pitch: f64) -> VehicleRates {
    let rate = AngularRate::from_radians_per_second;
    VehicleRates::turning(rate(yaw), rate(pitch))
}

pub(crate) fn command(pan: f64, tilt: f64) -> CameraCommand {
    let rate = AngularRate::from_radians_per_second;
    CameraCommand::turning(rate(pan), rate(tilt))
}

pub(crate) fn log_from_rows(
    rows: impl IntoIterator<Item = (Option<ImagePoint>, Option<CameraCommand>)>,
) -> TrialLog {
    let rows = rows.into_iter().enumerate();
    let rows = rows.map(|(row, (position, command))| LogRow { time_s: row as f64 * 0.5, position, command });
    TrialLog {
        rows: rows.collect(),
        last_row_duration_s: 0.5,
        frame: PICTURE,
        picture: PICTURE,
        records_track_loss: true,
        truth: None,
        selections: None,
        guidance: None,
        water: None,
    }
}

/// A log with one character per row: `.` P = 0, `o` P = 1, `a` P = 2.25, `b` P = 4, `c` P = 9, `-` no
/// position.
pub(crate) fn log_from(rows: &str) -> TrialLog {
    let x = |row: char| match row {
        '.' => Some(0.0),
        'o' => Some(100.0),
        'a' => Some(150.0),
        'b' => Some(-200.0),
        'c' => Some(300.0),
        '-' => None,
        other => panic!("unknown row {other}"),
    };
    log_from_rows(
        rows.chars().map(|row| (x(row).map(|x| ImagePoint { x, y: 0.0 }), Some(CameraCommand::REST))),
    )
}

pub(crate) fn measured(rows: &str) -> TrialMetrics {
    measure(&log_from(rows), REGION, PICTURE)
}
