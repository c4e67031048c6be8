//! The CSV of a trial: `barrelman export` writes it from a recording, `barrelman law` from a log.
//!
//! Columns are identified by name: `time_s,x,y` and the rates are required; `picture_width,picture_height`
//! give the size of the frame (by default the laboratory's); others are ignored. x or y is empty while the
//! track is lost. The rates are `pan_rate,tilt_rate` (positive to the right and upwards), or
//! `pitch_rate,yaw_rate` in the Fotokite Pro's own signs, as `barrelman law` writes them.

use std::borrow::Cow;

use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, PictureSize};

use super::csv::{ParsedLog, complete_lines, parse_number, parse_optional_number};
use super::laboratory;
use super::log_error::LogError;
use super::trial_log::{LogRow, TrialLog};
use crate::csv_row::cells;

/// Header of the files that `export` writes.
pub const HEADER: &str = "time_s,x,y,p,pan_rate,tilt_rate,mode,picture_width,picture_height";

const REQUIRED: [&str; 3] = ["time_s", "x", "y"];
/// The two forms of the rates.
const PAN_AND_TILT: [&str; 2] = ["pan_rate", "tilt_rate"];
const PITCH_AND_YAW: [&str; 2] = ["pitch_rate", "yaw_rate"];

/// The columns of the rates.
enum RateColumns {
    PanAndTilt(usize, usize),
    PitchAndYaw(usize, usize),
}

impl RateColumns {
    /// The columns of a header; pan and tilt where it has both forms.
    fn find(column: impl Fn(&str) -> Option<usize>) -> Option<Self> {
        let both = |[first, second]: [&str; 2]| column(first).zip(column(second));
        let pan_and_tilt = both(PAN_AND_TILT).map(|(pan, tilt)| Self::PanAndTilt(pan, tilt));
        pan_and_tilt.or_else(|| both(PITCH_AND_YAW).map(|(pitch, yaw)| Self::PitchAndYaw(pitch, yaw)))
    }

    /// The command of a row; `None` where a rate is blank.
    fn command(&self, fields: &[Cow<'_, str>], line: usize) -> Result<Option<CameraCommand>, LogError> {
        let rate = AngularRate::from_radians_per_second;
        let read = |(first, second): (usize, usize), names: [&'static str; 2]| {
            let first = parse_optional_number(&fields[first], line, names[0])?;
            Ok::<_, LogError>(first.zip(parse_optional_number(&fields[second], line, names[1])?))
        };
        Ok(match self {
            Self::PanAndTilt(pan, tilt) => read((*pan, *tilt), PAN_AND_TILT)?
                .map(|(pan, tilt)| CameraCommand::turning(rate(pan), rate(tilt))),
            Self::PitchAndYaw(pitch, yaw) => {
                read((*pitch, *yaw), PITCH_AND_YAW)?.map(|(pitch, yaw)| laboratory::command_of(pitch, yaw))
            }
        })
    }
}

/// Whether a text begins with a header that has the required columns.
pub fn has_header(text: &str) -> bool {
    let names: Vec<&str> = text.lines().next().unwrap_or_default().split(',').map(str::trim).collect();
    let has_all = |columns: &[&str]| columns.iter().all(|column| names.contains(column));
    has_all(&REQUIRED) && (has_all(&PAN_AND_TILT) || has_all(&PITCH_AND_YAW))
}

/// The size of the frame in a row; `None` where a side is blank.
fn frame_size((width, height): (&str, &str), line: usize) -> Result<Option<PictureSize>, LogError> {
    let Some(width) = parse_optional_number(width, line, "picture_width")? else { return Ok(None) };
    let Some(height) = parse_optional_number(height, line, "picture_height")? else { return Ok(None) };
    let side = |value: f64, column: &'static str| {
        let is_size = value.fract() == 0.0 && (1.0..=65_536.0).contains(&value);
        let error = LogError::NotASize { line, column, found: value };
        if is_size { Ok(value as u32) } else { Err(error) }
    };
    Ok(Some(PictureSize::new(side(width, "picture_width")?, side(height, "picture_height")?)))
}

/// Reads a log.
///
/// # Errors
/// [`LogError`] where the log has no rows, or where a row cannot be parsed.
pub fn read(text: &str) -> Result<ParsedLog, LogError> {
    let (mut lines, truncated_at_line) = complete_lines(text);
    if lines.is_empty() {
        return Err(LogError::Empty);
    }
    let (_, header) = lines.remove(0);
    let names: Vec<&str> = header.trim().split(',').map(str::trim).collect();
    let column = |name: &str| names.iter().position(|found| *found == name);
    let unknown = || LogError::UnknownHeader { found: header.trim().to_owned() };
    let [Some(time), Some(x), Some(y)] = REQUIRED.map(column) else { return Err(unknown()) };
    let rates = RateColumns::find(column).ok_or_else(unknown)?;
    let size_columns = column("picture_width").zip(column("picture_height"));
    let mut rows: Vec<LogRow> = Vec::with_capacity(lines.len());
    let mut size = None;
    for (line, content) in lines {
        let fields = cells(content.trim_end_matches(['\r', '\n']));
        if fields.len() != names.len() {
            return Err(LogError::FieldCount { line, found: fields.len(), expected: names.len() });
        }
        let time_s = parse_number(&fields[time], line, "time_s")?;
        if rows.last().is_some_and(|above| above.time_s > time_s) {
            return Err(LogError::TimeRunsBack { line, time_s });
        }
        let position =
            parse_optional_number(&fields[x], line, "x")?.zip(parse_optional_number(&fields[y], line, "y")?);
        let command = rates.command(&fields, line)?;
        if let Some((width, height)) = size_columns.filter(|_| size.is_none()) {
            size = frame_size((&fields[width], &fields[height]), line)?;
        }
        rows.push(LogRow { time_s, position: position.map(|(x, y)| ImagePoint { x, y }), command });
    }
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Err(LogError::Empty) };
    let start_s = first.time_s;
    let last_row_duration_s =
        if rows.len() > 1 { (last.time_s - start_s) / (rows.len() - 1) as f64 } else { 0.0 };
    for row in &mut rows {
        row.time_s -= start_s;
    }
    let (frame, picture) = size.map_or((laboratory::FRAME, laboratory::PICTURE), |size| (size, size));
    let records_track_loss = rows.iter().any(|row| row.position.is_none()) || size.is_some();
    let log = TrialLog {
        rows,
        last_row_duration_s,
        frame,
        picture,
        records_track_loss,
        truth: None,
        selections: None,
        guidance: None,
        water: None,
    };
    Ok(ParsedLog { log, truncated_at_line })
}
