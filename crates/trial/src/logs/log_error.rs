//! Errors of reading a log.

/// A log cannot be read. Lines count from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LogError {
    /// The log has no rows.
    #[error("the log has no rows")]
    Empty,
    /// The first line is not the header of a known kind of log.
    #[error(
        "not a trial log: the file begins with {found:?}; expected the laboratory's x_val,y_val,pitch,yaw,val,time, \
         a CSV with the columns time_s,x,y,pan_rate,tilt_rate, or an MCAP recording"
    )]
    UnknownHeader {
        /// The beginning of the file.
        found: String,
    },
    /// The number of fields of a row differs from the first row's.
    #[error("line {line}: {found} fields where the first row has {expected}")]
    FieldCount {
        /// Line in the file.
        line: usize,
        /// Number of fields in the line.
        found: usize,
        /// Number of fields in the first row.
        expected: usize,
    },
    /// A field is not a number.
    #[error("line {line}: {column} is {found:?}, which is not a number")]
    NotANumber {
        /// Line in the file.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// Content of the field.
        found: String,
    },
    /// A side of the picture is not a whole number of pixels within the limits.
    #[error("line {line}: {column} is {found}, which is not a whole number of pixels from 1 to 65536")]
    NotASize {
        /// Line in the file.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// Content of the field.
        found: f64,
    },
    /// The time of a row is earlier than that of the row above.
    #[error("line {line}: the time {time_s} s is earlier than that of the row above")]
    TimeRunsBack {
        /// Line in the file.
        line: usize,
        /// The time, s.
        time_s: f64,
    },
}
