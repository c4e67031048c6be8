//! A trial out of a recording: its outcomes from the first localisation on.

use std::collections::VecDeque;

use barrelman_vocab::{PictureSize, Timestamp, VehicleRates};

use super::{LogRow, RowTruth, TrialLog, laboratory};
use crate::records::{RecordedOutcome, RecordedTruth};

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
    /// What was true of the pictures that may still arrive, by their time of capture.
    on_the_way: VecDeque<RecordedTruth>,
    /// What was true of the newest picture that arrived.
    newest: Option<RecordedTruth>,
    truth: Vec<RowTruth>,
    /// The longest that a picture took to the pilot.
    most_age_ns: u64,
    last_at: Timestamp,
}

/// A picture is on its way for at most so many others.
const MOST_ON_THE_WAY: usize = 256;

impl Collector {
    /// Takes the next outcome.
    pub fn take(&mut self, outcome: &RecordedOutcome) {
        if let Some(seen) = outcome.track.localisation() {
            self.size.get_or_insert(seen.picture);
        }
        if let Some(age) = outcome.age {
            // The age of what was seen says when it was taken, also where nothing was found in it.
            let age_ns = u64::try_from(age.as_nanos()).unwrap_or(u64::MAX);
            self.most_age_ns = self.most_age_ns.max(age_ns);
            self.arrived(Timestamp::from_nanos(outcome.at.as_nanos().saturating_sub(age_ns)));
        }
        self.last_at = outcome.at;
        if !self.rows_taken.takes(outcome) {
            return;
        }
        let start = *self.start.get_or_insert(outcome.at);
        self.rows.push(LogRow {
            time_s: outcome.at.since(start).as_secs_f64(),
            position: outcome.percept.map(|percept| percept.position),
            rates: Some(outcome.rates),
        });
        if let Some(truth) = self.newest {
            self.truth.push(RowTruth {
                out_of_picture: !truth.in_picture,
                achieved: None,
                target_m: truth.target_m,
                camera_m: (truth.camera_m.0, truth.camera_m.1),
            });
        }
    }

    /// Pictures that were taken until then have arrived, or never will.
    fn arrived(&mut self, captured: Timestamp) {
        while let Some(truth) = self.on_the_way.pop_front_if(|truth| truth.at <= captured) {
            // Of a picture in which nothing was localised there may be no row: the row before stands for it.
            if let Some(passed) = self.newest.replace(truth)
                && !passed.in_picture
                && let Some(row) = self.truth.last_mut()
            {
                row.out_of_picture = true;
            }
        }
    }

    /// Takes what was true of the next picture of a simulated world.
    pub fn take_truth(&mut self, truth: RecordedTruth) {
        self.on_the_way.push_back(truth);
        if self.on_the_way.len() > MOST_ON_THE_WAY {
            // A long stretch in which nothing was localised: its oldest picture is not waited for any more.
            self.arrived(self.on_the_way[0].at);
        }
    }

    /// The log; `None` where nothing was ever localised.
    pub fn finish(mut self) -> Option<TrialLog> {
        let arrived_until = self.last_at.as_nanos().saturating_sub(self.most_age_ns);
        self.arrived(Timestamp::from_nanos(arrived_until));
        if let (Some(row), Some(newest)) = (self.truth.last_mut(), self.newest) {
            row.out_of_picture |= !newest.in_picture;
        }
        let last = self.rows.last()?;
        let last_row_s = match self.rows.len() {
            1 => 1.0 / laboratory::ROWS_PER_SECOND,
            rows => last.time_s / (rows - 1) as f64,
        };
        let size = self.size?;
        // A recording of a simulated world has the truth of every row, another one of none.
        let truth = (self.truth.len() == self.rows.len()).then_some(self.truth);
        Some(TrialLog { rows: self.rows, last_row_s, frame: size, picture: size, knows_lost: true, truth })
    }
}
