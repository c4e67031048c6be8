//! Means and quantiles.

/// Median, 99th percentile and mean of CPU times in milliseconds; not a number where there are none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) mean: f64,
}

impl Spread {
    /// Of these.
    pub(crate) fn of(times_ms: &[f64]) -> Self {
        Self { median: quantile(times_ms, 0.5), p99: quantile(times_ms, 0.99), mean: mean(times_ms) }
    }
}

/// The arithmetic mean; not a number where there is nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The value of which `share` (0 to 1) of the values are smaller, by the nearest rank; not a number where there is
/// nothing.
pub(crate) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let rank = (sorted.len().saturating_sub(1) as f64 * share).round() as usize;
    sorted.get(rank).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_nearest_rank() {
        let values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        let spread = Spread::of(&values);
        assert_eq!((spread.median, spread.p99, spread.mean), (50.0, 99.0, 50.0));
        assert!(quantile(&[], 0.5).is_nan());
    }
}
