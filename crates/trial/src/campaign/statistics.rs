//! Means with their uncertainty.
//!
//! [`mean_interval`] is Student's: for figures of independent trials. [`Bootstrap`] resamples trials with draws
//! that come from a hash, so that it gives the same interval each time; it is for ratios and for paired
//! differences, whose distribution nobody knows.

use barrelman_sim::noise;
use serde::Serialize;

/// A value with the interval that it lies in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Whether two intervals have a value in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low <= other.high && other.low <= self.high
    }
}

/// The mean of independent values and its 95 % interval; `None` of fewer than two.
pub fn mean_interval(values: &[f64]) -> Option<Interval> {
    let count = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (count - 1.0);
    let half = student_975(values.len() - 1) * (variance / count).sqrt();
    Some(Interval { value: mean, low: mean - half, high: mean + half })
}

/// The 97.5 % quantile of Student's distribution: by Cornish and Fisher's expansion, exact to 0.2 % from 4 degrees
/// of freedom on, and a table below.
pub fn student_975(degrees: usize) -> f64 {
    match degrees {
        0 => f64::INFINITY,
        1 => 12.706_204_736,
        2 => 4.302_652_730,
        3 => 3.182_446_305,
        _ => {
            let (z, n) = (1.959_963_984_540_054_f64, degrees as f64);
            let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
            z + (z3 + z) / (4.0 * n)
                + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
                + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n * n * n)
        }
    }
}

/// Resampling with replacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// How often.
    pub times: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Share of the resampled values that the interval holds, between 0 and 1.
    pub confidence: f64,
}

impl Bootstrap {
    /// 10,000 times, 95 %.
    pub const USUAL: Self = Self { times: 10_000, seed: 1, confidence: 0.95 };

    /// The statistic of `count` trials with the interval of its values over resampled trials. The statistic is
    /// given which trials to take, each as often as it was drawn; values that are not finite are left out.
    /// `None` where there are none.
    pub fn interval(&self, count: usize, statistic: impl Fn(&[usize]) -> f64) -> Option<Interval> {
        if count == 0 {
            return None;
        }
        let mut taken: Vec<usize> = (0..count).collect();
        let value = statistic(&taken);
        let mut values = Vec::with_capacity(self.times);
        for round in 0..self.times {
            for (index, slot) in taken.iter_mut().enumerate() {
                let draw = noise::unit(self.seed, round as u64, index as u64);
                *slot = ((draw * count as f64) as usize).min(count - 1);
            }
            let resampled = statistic(&taken);
            if resampled.is_finite() {
                values.push(resampled);
            }
        }
        values.sort_by(f64::total_cmp);
        let at =
            |share: f64| values.get(((share * values.len() as f64) as usize).min(values.len().max(1) - 1));
        let tail = 0.5 * (1.0 - self.confidence);
        let (low, high) = (at(tail)?, at(1.0 - tail)?);
        value.is_finite().then_some(Interval { value, low: *low, high: *high })
    }
}
