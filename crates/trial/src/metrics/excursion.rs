//! Excursions: the target leaves the region and comes back (`biswas2017`).

use barrelman_control::Region;

use crate::logs::TrialLog;

/// A maximal run of rows with P > 1. A row without a position counts as the row before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excursion {
    /// Index of the first row outside.
    pub first: usize,
    /// Index of the first row back inside; the number of rows where the log ends outside.
    pub end: usize,
    /// Whether the log continues after the excursion.
    pub is_complete: bool,
    /// Height: the largest P minus 1.
    pub h: f64,
    /// Duration, s.
    pub b_s: f64,
}

impl Excursion {
    /// h/b, 1/s; `None` where the duration is zero.
    pub fn sensitivity(&self) -> Option<f64> {
        (self.b_s > 0.0).then(|| self.h / self.b_s)
    }
}

/// The excursions of a trial.
pub fn find_excursions(log: &TrialLog, region: Region) -> Vec<Excursion> {
    let mut found: Vec<Excursion> = Vec::new();
    let mut open: Option<(usize, f64)> = None;
    let mut close = |first: usize, end: usize, largest_p: f64, is_complete: bool| {
        let b_s = (first..end).map(|row| log.row_duration_s(row)).sum();
        found.push(Excursion { first, end, is_complete, h: largest_p - 1.0, b_s });
    };
    for (index, row) in log.rows.iter().enumerate() {
        let Some(p) = row.position.map(|position| region.p(position)) else { continue };
        open = match (open, p > 1.0) {
            (None, true) => Some((index, p)),
            (Some((first, largest)), true) => Some((first, largest.max(p))),
            (Some((first, largest)), false) => {
                close(first, index, largest, true);
                None
            }
            (None, false) => None,
        };
    }
    if let Some((first, largest)) = open {
        close(first, log.rows.len(), largest, false);
    }
    found
}
