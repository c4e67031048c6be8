//! The metrics by which simulated trials are compared with recorded ones, without excursions that a jump
//! spoils.

use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::find_excursions;

use super::laboratory::region;
use super::position_jump::is_jump;

/// The metrics of one trial. Unless stated otherwise, excursions in which the position jumped do not count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ExcursionSummary {
    duration_s: f64,
    excursions: usize,
    time_outside_s: f64,
    /// Mean duration b and mean height h of the complete excursions; `None` where no excursion is complete.
    mean_b_s: Option<f64>,
    mean_h: Option<f64>,
    /// Mean sensitivity of the complete excursions, 1/s.
    pub(super) sensitivity: Option<f64>,
    /// Integral of the commanded |rate| over both axes, rad, without rows of excursions with a jump.
    travel_rad: f64,
    /// How many excursions have a jump.
    pub(super) excursions_with_jumps: usize,
}

/// A metric: its name in the table, and its value for a trial.
pub(super) type Metric = (&'static str, fn(&ExcursionSummary) -> Option<f64>);

/// The metrics in the order of the table.
pub(super) const METRICS: [Metric; 7] = [
    ("duration, s", |summary| Some(summary.duration_s)),
    ("excursions", |summary| Some(summary.excursions as f64)),
    ("time outside, %", |summary| Some(100.0 * summary.time_outside_s / summary.duration_s)),
    ("duration of an excursion b, s", |summary| summary.mean_b_s),
    ("height h", |summary| summary.mean_h),
    ("sensitivity, 1/s", |summary| summary.sensitivity),
    ("integral of |rate|, rad", |summary| Some(summary.travel_rad)),
];

impl ExcursionSummary {
    /// Measures a trial.
    pub(super) fn from_log(log: &TrialLog) -> Self {
        let all = find_excursions(log, region(log));
        let has_jump =
            |first: usize, end: usize| (first..=end.min(log.rows.len() - 1)).any(|row| is_jump(log, row));
        let kept: Vec<_> = all.iter().filter(|excursion| !has_jump(excursion.first, excursion.end)).collect();
        let complete: Vec<_> = kept.iter().filter(|excursion| excursion.is_complete).collect();
        let travel_rad: f64 = (0..log.rows.len())
            .filter(|row| !all.iter().any(|e| has_jump(e.first, e.end) && (e.first..e.end).contains(row)))
            .filter_map(|row| {
                let command = log.rows[row].command?;
                let rate = command.pan.radians_per_second().abs() + command.tilt.radians_per_second().abs();
                Some(rate * log.row_duration_s(row))
            })
            .sum();
        Self {
            duration_s: log.duration_s(),
            excursions: kept.len(),
            time_outside_s: kept.iter().map(|excursion| excursion.b_s).sum(),
            mean_b_s: mean(complete.iter().map(|excursion| excursion.b_s).collect()),
            mean_h: mean(complete.iter().map(|excursion| excursion.h).collect()),
            sensitivity: mean(complete.iter().filter_map(|excursion| excursion.sensitivity()).collect()),
            travel_rad,
            excursions_with_jumps: all.len() - kept.len(),
        }
    }
}

fn mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| crate::statistics::mean(&values))
}
