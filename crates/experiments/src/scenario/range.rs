//! Holds a value of a scenario's file to its range.

use super::error::ScenarioError;

/// The value, if it lies from `min` to `max`.
///
/// # Errors
/// Names the key, the unit and the range.
pub(super) fn within(key: &str, value: f64, min: f64, max: f64, unit: &str) -> Result<f64, ScenarioError> {
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(ScenarioError::value(key, format!("{value}: use {unit} from {min} to {max}")))
    }
}
