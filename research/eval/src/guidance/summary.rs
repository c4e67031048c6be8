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
        format!("{}  {}  {}", ratio_cell(self.cross_track), ratio_cell(self.time), ratio_cell(self.rudder))
    }
}

/// A ratio with its interval; a dash where there is none.
pub(super) fn ratio_cell(ratio: Option<Interval>) -> String {
    ratio.map_or_else(|| "-".to_owned(), |r| format!("{:.2} [{:.2}, {:.2}]", r.value, r.low, r.high))
}

fn ratio(lab: &[Outcome], ours: &[Outcome], value: fn(&Outcome) -> f64) -> Option<Interval> {
    let pairs: Vec<(f64, f64)> = lab.iter().zip(ours).map(|(lab, ours)| (value(lab), value(ours))).collect();
    ratio_of_means(&pairs)
}

/// The ratio of the means of pairs of values, the second to the first, with its interval over resampled
/// pairs.
pub(super) fn ratio_of_means(pairs: &[(f64, f64)]) -> Option<Interval> {
    Bootstrap::DEFAULT.interval(pairs.len(), |sample| {
        let sum = |part: fn(&(f64, f64)) -> f64| sample.iter().map(|index| part(&pairs[*index])).sum::<f64>();
        sum(|pair| pair.1) / sum(|pair| pair.0)
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
