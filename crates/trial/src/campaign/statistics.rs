//! Means with confidence intervals.
//!
//! [`mean_interval`] is Student's interval, for values of independent trials. [`Bootstrap`] resamples trials
//! with numbers from a hash, so that it is repeatable; it serves ratios and paired differences, whose
//! distribution is unknown.

use barrelman_sim::noise;
use serde::Serialize;

/// An estimate with its confidence interval.
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
    /// Whether two intervals share a value.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low <= other.high && other.low <= self.high
    }
}

/// The mean of independent values with Student's 95 % interval; `None` for fewer than two values.
pub fn mean_interval(values: &[f64]) -> Option<Interval> {
    let count = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (count - 1.0);
    let half = student_t_975(values.len() - 1) * (variance / count).sqrt();
    Some(Interval { value: mean, low: mean - half, high: mean + half })
}

/// The 97.5 % quantile of Student's t distribution. From 4 degrees of freedom on by the Cornish-Fisher
/// expansion, with a relative error of at most 0.2 %; below from a table.
pub fn student_t_975(degrees: usize) -> f64 {
    match degrees {
        0 => f64::INFINITY,
        1 => 12.706_204_736,
        2 => 4.302_652_730,
        3 => 3.182_446_305,
        _ => {
            let (z, n) = (1.959_963_984_540_054_f64, degrees as f64);
            let [z3, z5, z7] = odd_powers(z);
            z + (z3 + z) / (4.0 * n)
                + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
                + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n * n * n)
        }
    }
}

/// The third, fifth and seventh power.
fn odd_powers(z: f64) -> [f64; 3] {
    let (square, fourth) = (z * z, (z * z) * (z * z));
    [z * square, z * fourth, (z * square) * fourth]
}

/// The percentile bootstrap: resampling with replacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// Number of resamples.
    pub resamples: usize,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Confidence level, 0 to 1.
    pub confidence: f64,
}

impl Bootstrap {
    /// 10,000 resamples, 95 %.
    pub const DEFAULT: Self = Self { resamples: 10_000, seed: 1, confidence: 0.95 };

    /// The statistic of `count` trials with its interval over resampled trials. `statistic` receives the
    /// indices of the trials to evaluate, with repetitions. Resamples whose statistic is not finite are left
    /// out. `None` where `count` is 0, or where no value is finite.
    pub fn interval(&self, count: usize, statistic: impl Fn(&[usize]) -> f64) -> Option<Interval> {
        if count == 0 {
            return None;
        }
        let mut sample: Vec<usize> = (0..count).collect();
        let value = statistic(&sample);
        let mut values = Vec::with_capacity(self.resamples);
        for resample in 0..self.resamples {
            for (index, slot) in sample.iter_mut().enumerate() {
                let random = noise::unit(self.seed, resample as u64, index as u64);
                *slot = ((random * count as f64) as usize).min(count - 1);
            }
            let resampled = statistic(&sample);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::disallowed_methods, reason = "the products replace `powi` and keep its bits")]
    fn powers_have_the_bits_of_powi() {
        let mut z = 1.959_963_984_540_054_f64;
        for _ in 0..10_000 {
            assert_eq!(odd_powers(z), [z.powi(3), z.powi(5), z.powi(7)], "{z}");
            assert_eq!([z * z, (z * z) * (z * z)], [z.powi(2), z.powi(4)], "{z}");
            // The logistic map: values all over 0 to 4.
            z = z * (4.0 - z);
        }
    }
}
