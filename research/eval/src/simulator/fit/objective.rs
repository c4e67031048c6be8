//! The misfit between simulated and recorded motion.
//!
//! Compared are the means over the trials of all statistics of the motion, and the spread of some of them
//! over the trials, each in standard errors of the recorded value.

use anyhow::Result;
use barrelman_sim::Scenario;
use barrelman_sim::scenario::TargetScript;

use super::parameters::{ScaledScript, UnitPoint, at_point};
use crate::simulator::laboratory::simulate;
use crate::simulator::motion::{Group, MotionStatistics, STATISTICS};

/// Agreement closer than this share of the recorded mean is not required: the script is only a model of a
/// person.
const MIN_RELATIVE_ERROR: f64 = 0.05;
/// From this many standard errors on the loss grows linearly.
const HUBER_THRESHOLD: f64 = 3.0;

/// A compared figure.
pub(super) struct Figure {
    pub(super) name: &'static str,
    group: Group,
    /// Index of its statistic.
    statistic: usize,
    moment: Moment,
}

/// How a figure follows from a statistic's values in the trials.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Moment {
    Mean,
    /// The standard deviation as a share of the mean.
    Spread,
}

impl Figure {
    /// The means of all statistics, then the spreads.
    fn all() -> Vec<Self> {
        let means = STATISTICS.iter().enumerate().map(|(statistic, entry)| Self {
            name: entry.name,
            group: entry.group,
            statistic,
            moment: Moment::Mean,
        });
        let spreads = STATISTICS.iter().enumerate().filter_map(|(statistic, entry)| {
            let name = entry.spread?;
            Some(Self { name, group: Group::SpreadOverTrials, statistic, moment: Moment::Spread })
        });
        means.chain(spreads).collect()
    }

    fn value(&self, trials: &[MotionStatistics]) -> f64 {
        let count = trials.len() as f64;
        let mean = trials.iter().map(|trial| trial.values[self.statistic]).sum::<f64>() / count;
        match self.moment {
            Moment::Mean => mean,
            Moment::Spread => {
                let squares: f64 =
                    trials.iter().map(|trial| (trial.values[self.statistic] / mean - 1.0).powi(2)).sum();
                (squares / (count - 1.0)).sqrt()
            }
        }
    }

    /// The standard error of a figure's value: of a mean from the trials, of a spread that of a normal
    /// distribution.
    fn standard_error(&self, trials: &[MotionStatistics], value: f64) -> f64 {
        let count = trials.len() as f64;
        match self.moment {
            Moment::Mean => {
                let squares: f64 =
                    trials.iter().map(|trial| (trial.values[self.statistic] - value).powi(2)).sum();
                (squares / (count - 1.0) / count).sqrt().max(MIN_RELATIVE_ERROR * value.abs())
            }
            Moment::Spread => value / (2.0 * (count - 1.0)).sqrt(),
        }
    }
}

/// Huber's loss of a difference in standard errors.
fn huber_loss(errors: f64) -> f64 {
    let errors = errors.abs();
    if errors <= HUBER_THRESHOLD {
        errors * errors
    } else {
        HUBER_THRESHOLD * (2.0 * errors - HUBER_THRESHOLD)
    }
}

/// What the simulated motion is compared with, and how candidates are simulated.
pub(super) struct Objective {
    scenario: Scenario,
    pub(super) initial: ScaledScript,
    pub(super) figures: Vec<Figure>,
    /// For each figure, the recorded value and its standard error.
    pub(super) recorded: Vec<f64>,
    pub(super) standard_errors: Vec<f64>,
    /// The seeds that every candidate is simulated with.
    seeds: Vec<u64>,
}

impl Objective {
    pub(super) fn new(
        scenario: Scenario,
        initial: ScaledScript,
        trials: &[MotionStatistics],
        seeds: Vec<u64>,
    ) -> Self {
        let figures = Figure::all();
        let recorded: Vec<f64> = figures.iter().map(|figure| figure.value(trials)).collect();
        let standard_errors =
            figures.iter().zip(&recorded).map(|(figure, value)| figure.standard_error(trials, *value));
        let standard_errors = standard_errors.collect();
        Self { scenario, initial, figures, recorded, standard_errors, seeds }
    }

    /// Simulates a candidate. Returns the values of the figures.
    pub(super) fn simulate(&self, point: &UnitPoint) -> Result<Vec<f64>> {
        let target = TargetScript::Pursuit(at_point(&self.initial, point).scaled());
        let scenario = Scenario { target, ..self.scenario.clone() };
        let trials: Vec<_> = self
            .seeds
            .iter()
            .map(|seed| Ok(MotionStatistics::from_log(&simulate(&scenario, *seed)?, &scenario)))
            .collect::<Result<_>>()?;
        Ok(self.figures.iter().map(|figure| figure.value(&trials)).collect())
    }

    /// The misfit of values of the figures: the sum over the groups of the mean loss of their figures.
    pub(super) fn misfit(&self, values: &[f64]) -> f64 {
        let losses: Vec<f64> = values
            .iter()
            .zip(&self.recorded)
            .zip(&self.standard_errors)
            .map(|((value, recorded), error)| huber_loss((value - recorded) / error))
            .collect();
        let mut first = 0;
        self.groups()
            .map(|group| {
                let of_group = &losses[first..first + group.len()];
                first += group.len();
                of_group.iter().sum::<f64>() / group.len() as f64
            })
            .sum()
    }

    /// The figures by group.
    pub(super) fn groups(&self) -> impl Iterator<Item = &[Figure]> {
        self.figures.chunk_by(|a, b| a.group == b.group)
    }

    /// Simulates a candidate and returns its misfit.
    pub(super) fn evaluate(&self, point: &UnitPoint) -> Result<f64> {
        Ok(self.misfit(&self.simulate(point)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_group_is_one_run_of_figures() {
        let figures = Figure::all();
        let groups: Vec<Group> =
            figures.chunk_by(|a, b| a.group == b.group).map(|run| run[0].group).collect();
        for (index, group) in groups.iter().enumerate() {
            assert!(!groups[..index].contains(group), "{group:?}");
        }
        assert_eq!(groups.last(), Some(&Group::SpreadOverTrials));
    }
}
