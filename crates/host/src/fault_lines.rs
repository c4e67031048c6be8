//! Files of deliberate faults: one place with its plan a line.
//!
//! ```text
//! # place: faults, as on the command line; times count from the program's start
//! link: stall@5+2, disconnect@20+1
//! pilot: hang@30
//! program: suspend@40+5
//! ```

use super::fault::{FaultPlan, FaultPlanError};

/// The plan of one place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlacedFaults {
    /// The place: a thread, `link`, `video` or `program`.
    pub place: String,
    /// The plan.
    pub plan: FaultPlan,
}

/// A line that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FaultLinesError {
    /// There is no colon.
    #[error(
        "line {line}: `{text}` has no place: write PLACE: KIND@SECONDS[+DURATION], as in `link: stall@5+2`"
    )]
    NoPlace {
        /// Number of the line, from 1.
        line: usize,
        /// Its text.
        text: String,
    },
    /// The faults cannot be read.
    #[error("line {line}: {source}")]
    Plan {
        /// Number of the line, from 1.
        line: usize,
        /// The reason.
        source: FaultPlanError,
    },
}

/// Reads the lines of a file. What follows a `#` is a comment.
///
/// # Errors
/// The first line that cannot be read.
pub fn parse_fault_lines(text: &str) -> Result<Vec<PlacedFaults>, FaultLinesError> {
    let mut places = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let number = index + 1;
        let (place, plan) = line
            .split_once(':')
            .ok_or_else(|| FaultLinesError::NoPlace { line: number, text: line.to_owned() })?;
        let plan = FaultPlan::parse(plan).map_err(|source| FaultLinesError::Plan { line: number, source })?;
        places.push(PlacedFaults { place: place.trim().to_owned(), plan });
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_is_a_place_with_its_plan() {
        let text = "# a bad day\nlink: stall@5+2, disconnect@20+1\n\n  pilot:hang@30  # for good\r\nprogram: suspend@40+5\n";
        let read = parse_fault_lines(text).unwrap();
        let shown: Vec<String> =
            read.iter().map(|placed| format!("{}: {}", placed.place, placed.plan)).collect();
        assert_eq!(shown, ["link: stall@5+2,disconnect@20+1", "pilot: hang@30", "program: suspend@40+5"]);
        assert_eq!(parse_fault_lines(""), Ok(Vec::new()));
    }

    #[test]
    fn a_line_that_cannot_be_read_is_named() {
        for (text, line, named) in [
            ("link: stall@1\nstall@5", "line 2", "no place"),
            ("pilot: explode@5", "line 1", "explode"),
            ("\n\npilot: hang@soon", "line 3", "hang@soon"),
        ] {
            let said = parse_fault_lines(text).unwrap_err().to_string();
            assert!(said.contains(line) && said.contains(named), "{said}");
        }
    }
}
