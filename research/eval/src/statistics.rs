//! Means and quantiles.

use anyhow::{Context, Result};
use barrelman_trial::campaign::statistics::mean_interval;

/// Median, 99th percentile and mean of CPU times in milliseconds; NaN where there are no times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TimingSummary {
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) mean: f64,
}

impl TimingSummary {
    /// Summarises CPU times, milliseconds.
    pub(crate) fn from_times_ms(times_ms: &[f64]) -> Self {
        Self { median: quantile(times_ms, 0.5), p99: quantile(times_ms, 0.99), mean: mean(times_ms) }
    }
}

/// The arithmetic mean; NaN of no values.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The quantile of `share` (0 to 1) by the nearest rank; NaN of no values.
pub(crate) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let rank = (sorted.len().saturating_sub(1) as f64 * share).round() as usize;
    sorted.get(rank).copied().unwrap_or(f64::NAN)
}

/// The mean with half the width of its 95 % interval, as a table's cell.
///
/// # Errors
/// If there are fewer than two values.
pub(crate) fn mean_with_interval(values: &[f64]) -> Result<String> {
    let interval = mean_interval(values).context("fewer than two trials")?;
    Ok(format!("{:.3} +- {:.3}", interval.value, interval.high - interval.value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_nearest_rank() {
        let values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        let summary = TimingSummary::from_times_ms(&values);
        assert_eq!((summary.median, summary.p99, summary.mean), (50.0, 99.0, 50.0));
        assert!(quantile(&[], 0.5).is_nan());
    }
}
