//! Checks a value of a configuration file against its range.

use anyhow::{Result, bail, ensure};

/// The value of the file, or `base` without one, if it lies from `min` to `max`.
///
/// # Errors
/// If the value is out of range; the message names the key, the unit and the range.
pub(super) fn within(
    key: &str,
    value: Option<f64>,
    base: f64,
    min: f64,
    max: f64,
    unit: &str,
) -> Result<f64> {
    let value = value.unwrap_or(base);
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        bail!("{key} = {value}: use {unit} from {min} to {max}")
    }
}

/// Checks that an id of MAVLink names one system, or one component.
///
/// # Errors
/// If the id is 0; the message names the key.
pub(super) fn ensure_names_one(key: &str, id: u8) -> Result<()> {
    ensure!(id != 0, "{key} = 0: use 1 to 255; 0 addresses everybody");
    Ok(())
}
