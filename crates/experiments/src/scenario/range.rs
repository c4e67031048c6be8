//! Checks that a value of a scenario file lies in its range.

use barrelman_vocab::Angle;

use super::error::ScenarioError;

/// The value, if it lies from `min` to `max`.
///
/// # Errors
/// Names the key, the unit and the range.
pub(super) fn within(key: &str, value: f64, min: f64, max: f64, unit: &str) -> Result<f64, ScenarioError> {
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(ScenarioError::invalid(key, format!("{value}: use {unit} from {min} to {max}")))
    }
}

/// The angle of this many degrees, if they lie from `min` to `max`.
///
/// # Errors
/// As [`within`].
pub(super) fn angle_within(key: &str, degrees: f64, min: f64, max: f64) -> Result<Angle, ScenarioError> {
    within(key, degrees, min, max, "degrees").map(Angle::from_degrees)
}
