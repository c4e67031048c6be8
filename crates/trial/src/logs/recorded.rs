//! A trial out of a recording: its outcomes from the first localisation on.

use barrelman_vocab::{PictureSize, Timestamp, VehicleRates};

use super::{LogRow, TrialLog, laboratory};
use crate::records::RecordedOutcome;

/// Which outcomes are rows of a trial: from the first localisation on, every look, and every step between two
/// looks that changed the command.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    last: Option<VehicleRates>,
}

impl Rows {
    /// Whether this outcome, the next one, is a row.
    pub fn takes(&mut self, outcome: &RecordedOutcome) -> bool {
        let begins = self.last.is_none() && outcome.track.localisation().is_some();
        let goes_on = self.last.is_some_and(|last| outcome.age.is_some() || last != outcome.rates);
        if begins || goes_on {
            self.last = Some(outcome.rates);
        }
        begins || goes_on
    }
}

/// Collects outcomes as a log.
#[derive(Debug, Clone, Default)]
pub struct Collector {
    rows_taken: Rows,
    start: Option<Timestamp>,
    rows: Vec<LogRow>,
    size: Option<PictureSize>,
}

impl Collector {
    /// Takes the next outcome.
    pub fn take(&mut self, outcome: &RecordedOutcome) {
        if let Some(seen) = outcome.track.localisation() {
            self.size.get_or_insert(seen.picture);
        }
        if !self.rows_taken.takes(outcome) {
            return;
        }
        let start = *self.start.get_or_insert(outcome.at);
        self.rows.push(LogRow {
            time_s: outcome.at.since(start).as_secs_f64(),
            position: outcome.percept.map(|percept| percept.position),
            rates: Some(outcome.rates),
        });
    }

    /// The log; `None` where nothing was ever localised.
    pub fn finish(self) -> Option<TrialLog> {
        let last = self.rows.last()?;
        let last_row_s = match self.rows.len() {
            1 => 1.0 / laboratory::ROWS_PER_SECOND,
            rows => last.time_s / (rows - 1) as f64,
        };
        let size = self.size?;
        Some(TrialLog { rows: self.rows, last_row_s, frame: size, picture: size, knows_lost: true })
    }
}
