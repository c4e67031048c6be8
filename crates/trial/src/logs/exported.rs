//! The CSV of a trial: `barrelman export` writes it from a recording, `barrelman law` from a log.
//!
//! Columns are identified by name: `time_s,x,y,pitch_rate,yaw_rate` are required; `picture_width,picture_height` give the
//! size of the frame (by default the laboratory's); others are ignored. x or y is empty while the track is lost.

use barrelman_vocab::{AngularRate, ImagePoint, PictureSize, VehicleRates};

use super::csv::{ParsedLog, complete_lines, parse_number, parse_optional_number};
use super::laboratory;
use super::log_error::LogError;
use super::trial_log::{LogRow, TrialLog};

/// Header of the files that `export` writes.
pub const HEADER: &str = "time_s,x,y,p,pitch_rate,yaw_rate,mode,picture_width,picture_height";

const REQUIRED: [&str; 5] = ["time_s", "x", "y", "pitch_rate", "yaw_rate"];

/// Whether a text begins with a header that has the required columns.
pub fn has_header(text: &str) -> bool {
    let names: Vec<&str> = text.lines().next().unwrap_or_default().split(',').map(str::trim).collect();
    REQUIRED.iter().all(|required| names.contains(required))
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
    let [Some(time), Some(x), Some(y), Some(pitch), Some(yaw)] = REQUIRED.map(column) else {
        return Err(LogError::UnknownHeader { found: header.trim().to_owned() });
    };
    let size_columns = column("picture_width").zip(column("picture_height"));
    let mut rows: Vec<LogRow> = Vec::with_capacity(lines.len());
    let mut size = None;
    for (line, content) in lines {
        let fields: Vec<&str> = content.trim_end_matches(['\r', '\n']).split(',').collect();
        if fields.len() != names.len() {
            return Err(LogError::FieldCount { line, found: fields.len(), expected: names.len() });
        }
        let time_s = parse_number(fields[time], line, "time_s")?;
        if rows.last().is_some_and(|above| above.time_s > time_s) {
            return Err(LogError::TimeRunsBack { line, time_s });
        }
        let position =
            parse_optional_number(fields[x], line, "x")?.zip(parse_optional_number(fields[y], line, "y")?);
        let rates = parse_optional_number(fields[pitch], line, "pitch_rate")?.zip(parse_optional_number(
            fields[yaw],
            line,
            "yaw_rate",
        )?);
        if let Some((width, height)) = size_columns
            && size.is_none()
            && let Some(width) = parse_optional_number(fields[width], line, "picture_width")?
            && let Some(height) = parse_optional_number(fields[height], line, "picture_height")?
        {
            let side = |value: f64, column: &'static str| {
                let is_size = value.fract() == 0.0 && (1.0..=65_536.0).contains(&value);
                let error = LogError::NotASize { line, column, found: value };
                if is_size { Ok(value as u32) } else { Err(error) }
            };
            size = Some(PictureSize::new(side(width, "picture_width")?, side(height, "picture_height")?));
        }
        let rate = AngularRate::from_radians_per_second;
        rows.push(LogRow {
            time_s,
            position: position.map(|(x, y)| ImagePoint { x, y }),
            rates: rates.map(|(pitch, yaw)| VehicleRates { yaw: rate(yaw), pitch: rate(pitch) }),
        });
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
    };
    Ok(ParsedLog { log, truncated_at_line })
}
