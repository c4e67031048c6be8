//! The authors' laboratory logs (`biswas2017`).
//!
//! The first row follows the header `x_val,y_val,pitch,yaw,val,time` without a line end. Rows have 7 fields
//! (x, y in px from the centre with y up; pitch rate, yaw rate in rad/s as sent; P; a loop time; Unix time in
//! whole seconds), or 6 without the loop time; the first row decides. The rows have a constant rate,
//! [`ROWS_PER_SECOND`], which is used instead of the times. The rates have the Fotokite Pro's own signs; a
//! log's command has the program's. P refers to a 640x480 frame of which the picture fills 640x360. Pitch,
//! yaw and P may be blank.

use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, PictureSize, VehicleProfile, VehicleRates};

use super::csv::{ParsedLog, complete_lines, parse_number, parse_optional_number};
use super::log_error::LogError;
use super::trial_log::{LogRow, TrialLog};

/// Beginning of the file.
pub const HEADER: &str = "x_val,y_val,pitch,yaw,val,time";
/// Mean over all 30 trials: 71,914 rows in 1,931.63 s.
pub const ROWS_PER_SECOND: f64 = 37.23;
/// Size of the frame, whose width and height the region is a share of.
pub const FRAME: PictureSize = PictureSize::new(640, 480);
/// Size of the picture within the frame.
pub const PICTURE: PictureSize = PictureSize::new(640, 360);

/// The command that the Fotokite Pro was sent as these rates, rad/s.
pub(super) fn command_of(pitch: f64, yaw: f64) -> CameraCommand {
    let rate = AngularRate::from_radians_per_second;
    VehicleProfile::fotokite_pro().from_vehicle(VehicleRates::turning(rate(yaw), rate(pitch)))
}

/// Reads a log.
///
/// # Errors
/// [`LogError`] where the log has no rows, or where a row cannot be parsed.
pub fn read(text: &str) -> Result<ParsedLog, LogError> {
    let (lines, truncated_at_line) = complete_lines(text);
    let mut rows = Vec::with_capacity(lines.len());
    let mut expected = None;
    for (line, content) in lines {
        let row = if line == 1 { content.strip_prefix(HEADER).unwrap_or(content) } else { content };
        let row = row.trim_end_matches(['\r', '\n']);
        if row.is_empty() {
            // Edited by hand: a line end after the header, or an empty line at the end.
            continue;
        }
        let fields: Vec<&str> = row.split(',').collect();
        let expected = *expected.get_or_insert(fields.len());
        if fields.len() != expected || !(6..=7).contains(&expected) {
            let expected = if (6..=7).contains(&expected) { expected } else { 7 };
            return Err(LogError::FieldCount { line, found: fields.len(), expected });
        }
        let position =
            ImagePoint { x: parse_number(fields[0], line, "x")?, y: parse_number(fields[1], line, "y")? };
        let pitch = parse_optional_number(fields[2], line, "pitch")?;
        let yaw = parse_optional_number(fields[3], line, "yaw")?;
        rows.push(LogRow {
            time_s: rows.len() as f64 / ROWS_PER_SECOND,
            position: Some(position),
            command: pitch.zip(yaw).map(|(pitch, yaw)| command_of(pitch, yaw)),
        });
    }
    if rows.is_empty() {
        return Err(LogError::Empty);
    }
    let last_row_duration_s = 1.0 / ROWS_PER_SECOND;
    let log = TrialLog {
        rows,
        last_row_duration_s,
        frame: FRAME,
        picture: PICTURE,
        records_track_loss: false,
        truth: None,
        selections: None,
        guidance: None,
        water: None,
    };
    Ok(ParsedLog { log, truncated_at_line })
}
