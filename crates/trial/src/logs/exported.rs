//! The CSV of a trial that `barrelman export` writes from a recording, and `barrelman law` from a log.
//!
//! Columns go by name: `time_s,x,y,pitch_rate,yaw_rate` are needed, `picture_width,picture_height` tell the
//! frame (else it is the laboratory's), others are passed over. An empty x or y is a moment without a track.

use barrelman_vocab::{AngularRate, ImagePoint, PictureSize, VehicleRates};

use super::{LogError, LogRow, ReadLog, TrialLog, laboratory, number, optional_number, whole_lines};

/// The header that `export` writes.
pub const HEADER: &str = "time_s,x,y,p,pitch_rate,yaw_rate,mode,picture_width,picture_height";

const NEEDED: [&str; 5] = ["time_s", "x", "y", "pitch_rate", "yaw_rate"];

/// Whether a text begins with a header that has the needed columns.
pub fn is_campaign_file(text: &str) -> bool {
    let names: Vec<&str> = text.lines().next().unwrap_or_default().split(',').map(str::trim).collect();
    NEEDED.iter().all(|needed| names.contains(needed))
}

/// Reads a log.
///
/// # Errors
/// [`LogError`] where it has no rows or one of them cannot be understood.
pub fn read(text: &str) -> Result<ReadLog, LogError> {
    let (mut lines, cut_at_line) = whole_lines(text);
    if lines.is_empty() {
        return Err(LogError::Empty);
    }
    let (_, header) = lines.remove(0);
    let names: Vec<&str> = header.trim().split(',').map(str::trim).collect();
    let column = |name: &str| names.iter().position(|found| *found == name);
    let [Some(time), Some(x), Some(y), Some(pitch), Some(yaw)] = NEEDED.map(column) else {
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
        let time_s = number(fields[time], line, "time_s")?;
        if rows.last().is_some_and(|above| above.time_s > time_s) {
            return Err(LogError::TimeRunsBack { line, time_s });
        }
        let position = optional_number(fields[x], line, "x")?.zip(optional_number(fields[y], line, "y")?);
        let rates = optional_number(fields[pitch], line, "pitch_rate")?.zip(optional_number(
            fields[yaw],
            line,
            "yaw_rate",
        )?);
        if let Some((width, height)) = size_columns
            && size.is_none()
            && let Some(width) = optional_number(fields[width], line, "picture_width")?
            && let Some(height) = optional_number(fields[height], line, "picture_height")?
        {
            let side = |value: f64, column: &'static str| {
                let whole = value.fract() == 0.0 && (1.0..=65_536.0).contains(&value);
                let wrong = LogError::NotASize { line, column, found: value };
                if whole { Ok(value as u32) } else { Err(wrong) }
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
    let last_row_s = if rows.len() > 1 { (last.time_s - start_s) / (rows.len() - 1) as f64 } else { 0.0 };
    for row in &mut rows {
        row.time_s -= start_s;
    }
    let (frame, picture) = size.map_or((laboratory::FRAME, laboratory::PICTURE), |size| (size, size));
    let knows_lost = rows.iter().any(|row| row.position.is_none()) || size.is_some();
    let log = TrialLog { rows, last_row_s, frame, picture, knows_lost, truth: None };
    Ok(ReadLog { log, cut_at_line })
}
