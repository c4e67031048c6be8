//! The authors' laboratory logs (`biswas2017`).
//!
//! The header `x_val,y_val,pitch,yaw,val,time` runs straight into the first row, without a line end. Rows have 7
//! fields (x, y in px from the centre with y up; pitch rate, yaw rate in rad/s as sent; P; a loop time; unix
//! time in whole seconds) or 6 (no loop time); the first row says which. The rows came at a steady
//! [`ROWS_PER_SECOND`], which is used instead of the whole-second stamps. P was taken on a 640x480 frame of
//! which the picture fills 640x360. Pitch, yaw and P may be blank: nothing here needs them.

use barrelman_vocab::{AngularRate, ImagePoint, PictureSize, VehicleRates};

use super::{LogError, LogRow, ReadLog, TrialLog, number, optional_number, whole_lines};

/// How the file begins.
pub const HEADER: &str = "x_val,y_val,pitch,yaw,val,time";
/// Rows per second over all 30 trials: 71,914 rows in 1,931.63 s.
pub const ROWS_PER_SECOND: f64 = 37.23;
/// The frame that the region was a share of.
pub const FRAME: PictureSize = PictureSize::new(640, 480);
/// The picture in it.
pub const PICTURE: PictureSize = PictureSize::new(640, 360);

/// Reads a log.
///
/// # Errors
/// [`LogError`] where it has no rows or one of them cannot be understood.
pub fn read(text: &str) -> Result<ReadLog, LogError> {
    let (lines, cut_at_line) = whole_lines(text);
    let mut rows = Vec::with_capacity(lines.len());
    let mut expected = None;
    for (line, content) in lines {
        let row = if line == 1 { content.strip_prefix(HEADER).unwrap_or(content) } else { content };
        let row = row.trim_end_matches(['\r', '\n']);
        if row.is_empty() {
            // A file that was repaired by hand: a line end after the header, or an empty line at the end.
            continue;
        }
        let fields: Vec<&str> = row.split(',').collect();
        let expected = *expected.get_or_insert(fields.len());
        if fields.len() != expected || !(6..=7).contains(&expected) {
            let expected = if (6..=7).contains(&expected) { expected } else { 7 };
            return Err(LogError::FieldCount { line, found: fields.len(), expected });
        }
        let position = ImagePoint { x: number(fields[0], line, "x")?, y: number(fields[1], line, "y")? };
        let pitch = optional_number(fields[2], line, "pitch")?;
        let yaw = optional_number(fields[3], line, "yaw")?;
        let rate = AngularRate::from_radians_per_second;
        rows.push(LogRow {
            time_s: rows.len() as f64 / ROWS_PER_SECOND,
            position: Some(position),
            rates: pitch.zip(yaw).map(|(pitch, yaw)| VehicleRates { yaw: rate(yaw), pitch: rate(pitch) }),
        });
    }
    if rows.is_empty() {
        return Err(LogError::Empty);
    }
    let last_row_s = 1.0 / ROWS_PER_SECOND;
    let log = TrialLog { rows, last_row_s, frame: FRAME, picture: PICTURE, knows_lost: false, truth: None };
    Ok(ReadLog { log, cut_at_line })
}
