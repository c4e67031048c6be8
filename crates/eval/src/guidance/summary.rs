//! Means over the trials of a condition, and the ratios of two laws.

use barrelman_trial::campaign::statistics::{Bootstrap, Interval};

use super::trial::Outcome;
use crate::statistics::mean;

/// Ratios of the means of two laws over the same seeds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ratios {
    pub(super) cross_track: Option<Interval>,
    /// Over the seeds on which both arrive.
    pub(super) time: Option<Interval>,
    pub(super) rudder: Option<Interval>,
}

impl Ratios {
    pub(super) fn new(lab: &[Outcome], ours: &[Outcome]) -> Self {
        let of = |value: fn(&Outcome) -> f64| ratio(lab, ours, value);
        let (lab_arrived, ours_arrived): (Vec<Outcome>, Vec<Outcome>) = lab
            .iter()
            .zip(ours)
            .filter(|(lab, ours)| lab.arrived_s.is_some() && ours.arrived_s.is_some())
            .map(|(lab, ours)| (*lab, *ours))
            .unzip();
        Self {
            cross_track: of(|outcome| outcome.cross_track_m),
            time: ratio(&lab_arrived, &ours_arrived, |outcome| outcome.arrived_s.unwrap_or(f64::NAN)),
            rudder: of(|outcome| outcome.rudder_per_s),
        }
    }

    pub(super) fn cells(&self) -> String {
        let cell = |interval: Option<Interval>| {
            interval
                .map_or_else(|| "-".to_owned(), |r| format!("{:.2} [{:.2}, {:.2}]", r.value, r.low, r.high))
        };
        format!("{}  {}  {}", cell(self.cross_track), cell(self.time), cell(self.rudder))
    }
}

/// The ratio of the means of a value, with its interval over resampled seeds.
fn ratio(lab: &[Outcome], ours: &[Outcome], value: fn(&Outcome) -> f64) -> Option<Interval> {
    Bootstrap::DEFAULT.interval(lab.len(), |sample| {
        let sum = |outcomes: &[Outcome]| sample.iter().map(|index| value(&outcomes[*index])).sum::<f64>();
        sum(ours) / sum(lab)
    })
}

pub(super) fn arrivals(outcomes: &[Outcome]) -> usize {
    outcomes.iter().filter(|outcome| outcome.arrived_s.is_some()).count()
}

pub(super) fn least_clearance(outcomes: &[Outcome]) -> f64 {
    outcomes.iter().map(|outcome| outcome.clearance_m).fold(f64::INFINITY, f64::min)
}

pub(super) fn mean_of(outcomes: &[Outcome], value: impl Fn(&Outcome) -> f64) -> f64 {
    mean(&outcomes.iter().map(value).filter(|value| value.is_finite()).collect::<Vec<f64>>())
}

pub(super) fn mean_of_arrived(outcomes: &[Outcome], value: impl Fn(&Outcome) -> Option<f64>) -> f64 {
    mean(&outcomes.iter().filter_map(value).collect::<Vec<f64>>())
}
