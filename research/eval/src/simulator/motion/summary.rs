//! Mean and quantiles that are 0 where there are no values.

/// Values in ascending order.
pub(super) struct SortedValues(Vec<f64>);

impl SortedValues {
    pub(super) fn new(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        Self(values)
    }

    /// The quantile of a share, 0 to 1.
    pub(super) fn quantile(&self, share: f64) -> f64 {
        let index = (share * self.0.len() as f64) as usize;
        self.0.get(index.min(self.0.len().max(1) - 1)).copied().unwrap_or(0.0)
    }

    /// The share of values above a limit.
    pub(super) fn share_above(&self, limit: f64) -> f64 {
        self.0.iter().filter(|value| **value > limit).count() as f64 / self.0.len().max(1) as f64
    }
}

pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    sum / count.max(1) as f64
}
