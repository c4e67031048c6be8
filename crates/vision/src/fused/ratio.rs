//! Comparison of two quantities by their ratio.

/// Whether a ratio lies between 1 / `factor` and `factor`.
pub(super) fn is_within(ratio: f32, factor: f32) -> bool {
    (1.0 / factor..=factor).contains(&ratio)
}
