//! The log of a trial from a recording: its outcomes from the first localisation on.

use std::collections::VecDeque;

use barrelman_vocab::{OperatorRequest, PictureSize, Timestamp, VehicleRates};

use super::laboratory;
use super::trial_log::{LogRow, RowTruth, TrialLog};
use super::water_log::WaterLog;
use crate::records::{RecordedInput, RecordedOutcome, RecordedTruth};
use crate::target_in_picture::JudgedTrack;

/// Selects the outcomes that are rows of a log: from the first localisation on, every outcome of a look at a
/// picture, and every other outcome that changed the command.
#[derive(Debug, Clone, Default)]
pub struct RowSelector {
    /// The rates of the last row.
    last_rates: Option<VehicleRates>,
}

impl RowSelector {
    /// Whether the next outcome is a row. `is_in_pixels`: the recording is one of a simulated trial in
    /// pixels, whose log begins with the first picture.
    pub fn accepts(&mut self, outcome: &RecordedOutcome, is_in_pixels: bool) -> bool {
        let is_measured = outcome.track.localisation().is_some() || (is_in_pixels && outcome.age.is_some());
        let begins = self.last_rates.is_none() && is_measured;
        let continues = self.last_rates.is_some_and(|last| outcome.age.is_some() || last != outcome.rates);
        if begins || continues {
            self.last_rates = Some(outcome.rates);
        }
        begins || continues
    }
}

/// Builds a log from the outcomes and truths of a recording.
#[derive(Debug, Clone, Default)]
pub struct LogBuilder {
    selector: RowSelector,
    start: Option<Timestamp>,
    rows: Vec<LogRow>,
    size: Option<PictureSize>,
    /// Truths of pictures that may not have reached the pilot yet, by their time of capture.
    in_flight: VecDeque<RecordedTruth>,
    /// Truth of the newest picture that reached the pilot.
    newest: Option<RecordedTruth>,
    truth: Vec<RowTruth>,
    /// Number of selections.
    selections: usize,
    /// Longest time from the capture of a picture to the pilot.
    max_age_ns: u64,
    last_at: Timestamp,
    water: WaterLog,
}

/// Upper bound of the pictures in flight.
const MAX_IN_FLIGHT: usize = 256;

impl LogBuilder {
    /// Adds the next outcome.
    pub fn add_outcome(&mut self, outcome: &RecordedOutcome) {
        if let Some(localisation) = outcome.track.localisation() {
            self.size.get_or_insert(localisation.picture);
        }
        if let Some(age) = outcome.age {
            // The age gives the time of capture also where the picture had no localisation.
            let age_ns = u64::try_from(age.as_nanos()).unwrap_or(u64::MAX);
            self.max_age_ns = self.max_age_ns.max(age_ns);
            self.settle_until(Timestamp::from_nanos(outcome.at.as_nanos().saturating_sub(age_ns)));
        }
        self.last_at = outcome.at;
        if let Some(vessel) = &outcome.vessel {
            self.water.add(vessel);
        }
        let judged = self
            .newest
            .and_then(|truth| Some(JudgedTrack::new(outcome.track, &truth.target?, truth.target_position)));
        if !self.selector.accepts(outcome, judged.is_some()) {
            return;
        }
        let start = *self.start.get_or_insert(outcome.at);
        self.rows.push(LogRow {
            time_s: outcome.at.since(start).as_secs_f64(),
            position: judged.map(|track| track.position).or(outcome.percept.map(|percept| percept.position)),
            command: Some(outcome.rates.in_the_senses_of(outcome.command)),
        });
        if let Some(truth) = self.newest {
            self.truth.push(RowTruth {
                out_of_picture: !truth.in_picture,
                achieved_rates: None,
                track: judged,
                target_m: truth.target_m,
                camera_m: (truth.camera_m.0, truth.camera_m.1),
            });
        }
    }

    /// Adds the next input.
    pub fn add_input(&mut self, input: &RecordedInput) {
        let is_selection = matches!(input, RecordedInput::Request(OperatorRequest::Camera(request)) if request.is_selection());
        self.selections += usize::from(is_selection);
    }

    /// Takes pictures captured until then out of flight: they have reached the pilot, or never will.
    fn settle_until(&mut self, captured: Timestamp) {
        while let Some(truth) = self.in_flight.pop_front_if(|truth| truth.at <= captured) {
            // A picture without a localisation may have no row of its own: the row before stands for it.
            if let Some(previous) = self.newest.replace(truth)
                && !previous.in_picture
                && let Some(row) = self.truth.last_mut()
            {
                row.out_of_picture = true;
            }
        }
    }

    /// Adds the truth of the next picture of a simulated world.
    pub fn add_truth(&mut self, truth: RecordedTruth) {
        self.in_flight.push_back(truth);
        if self.in_flight.len() > MAX_IN_FLIGHT {
            // No localisation for a long time: the oldest picture is settled.
            self.settle_until(self.in_flight[0].at);
        }
    }

    /// Returns the log; `None` where the recording has no localisation.
    pub fn finish(mut self) -> Option<TrialLog> {
        let settled_ns = self.last_at.as_nanos().saturating_sub(self.max_age_ns);
        self.settle_until(Timestamp::from_nanos(settled_ns));
        if let (Some(row), Some(newest)) = (self.truth.last_mut(), self.newest) {
            row.out_of_picture |= !newest.in_picture;
        }
        let last = self.rows.last()?;
        let last_row_duration_s = match self.rows.len() {
            1 => 1.0 / laboratory::ROWS_PER_SECOND,
            rows => last.time_s / (rows - 1) as f64,
        };
        let size = self.size?;
        // A recording of a simulated world has the truth of every row; any other recording has none.
        let truth = (self.truth.len() == self.rows.len()).then_some(self.truth);
        let is_in_pixels = truth.as_ref().is_some_and(|rows| rows.iter().any(|row| row.track.is_some()));
        Some(TrialLog {
            selections: is_in_pixels.then_some(self.selections),
            guidance: None,
            water: (!self.water.is_empty()).then_some(self.water),
            rows: self.rows,
            last_row_duration_s,
            frame: size,
            picture: size,
            records_track_loss: true,
            truth,
        })
    }
}
