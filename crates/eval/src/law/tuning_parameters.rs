//! The parameters of the optimal law that are tuned: their names for `--set`, and the ranges of the search.

use anyhow::{Context, Result, bail};
use barrelman_control::optimal::Tuning;

/// A parameter: its name, the range that is searched, and its field.
pub(super) type Parameter = (&'static str, (f64, f64), fn(&mut Tuning) -> &mut f64);

/// The parameters that are tuned. The names are words of the command line: they stay when a field is renamed.
pub(super) const PARAMETERS: [Parameter; 22] = [
    ("start", (0.7, 1.1), |t| &mut t.start),
    ("doubt", (0.0, 2.0), |t| &mut t.start_sigma),
    ("stop", (0.0, 1.0), |t| &mut t.stop),
    ("aim", (0.2, 1.0), |t| &mut t.aim),
    ("horizon_s", (0.6, 3.0), |t| &mut t.horizon_s),
    ("start_ahead_s", (0.0, 2.5), |t| &mut t.start_look_ahead_s),
    ("stop_ahead_s", (0.0, 2.0), |t| &mut t.stop_look_ahead_s),
    ("drift_s", (2.0, 30.0), |t| &mut t.recentring_time_s),
    ("least_rate", (0.01, 0.3), |t| &mut t.min_rate),
    ("most_rate", (0.2, 0.4), |t| &mut t.max_rate),
    ("least_share", (0.0, 0.9), |t| &mut t.min_axis_share),
    ("least_rest_s", (0.0, 0.6), |t| &mut t.min_rest_s),
    ("noise.rate", (0.05, 0.3), |t| &mut t.noise.rate_std_dev),
    ("noise.memory_s", (0.5, 6.0), |t| &mut t.noise.rate_time_constant_s),
    ("noise.look", (0.0005, 0.03), |t| &mut t.noise.measurement_std_dev),
    ("noise.sway", (0.0, 0.15), |t| &mut t.noise.max_sway_std_dev),
    ("noise.sway_memory_s", (0.3, 8.0), |t| &mut t.noise.sway_time_constant_s),
    ("fast", (0.01, 0.5), |t| &mut t.fast_target_rate),
    ("thrift", (0.0, 3.0), |t| &mut t.steep_view_gain),
    ("lazy", (0.0, 3.0), |t| &mut t.slow_target_gain),
    ("ease", (0.0, 0.4), |t| &mut t.slow_target_widening),
    ("hold", (0.0, 0.1), |t| &mut t.command_deadband),
];

/// A tuning with some of its values changed, each NAME=VALUE.
///
/// # Errors
/// If there is no parameter of that name, or the value is not a number.
pub(super) fn with_changes(mut tuning: Tuning, changes: &[String]) -> Result<Tuning> {
    for change in changes {
        let (name, value) = change.split_once('=').with_context(|| format!("{change}: write NAME=VALUE"))?;
        let Some((_, _, field)) = PARAMETERS.iter().find(|(known, ..)| *known == name) else {
            let known: Vec<&str> = PARAMETERS.iter().map(|(name, ..)| *name).collect();
            bail!("unknown value {name}; known are {}", known.join(", "));
        };
        *field(&mut tuning) = value.parse().with_context(|| format!("{change}: {value} is not a number"))?;
    }
    Ok(tuning)
}

/// The options `--set NAME=VALUE` that give a tuning.
pub(super) fn to_options(tuning: &Tuning) -> String {
    let mut tuning = *tuning;
    let options: Vec<String> =
        PARAMETERS.iter().map(|(name, _, field)| format!("--set {name}={:.4}", field(&mut tuning))).collect();
    options.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_lies_within_the_searched_ranges() {
        for mut tuning in [Tuning::MINIMUM_ENERGY, Tuning::TIME_FUEL, Tuning::ECO] {
            for (name, (low, high), field) in &PARAMETERS {
                let value = *field(&mut tuning);
                assert!((*low..=*high).contains(&value), "{name}: {value} is not in {low} to {high}");
            }
        }
    }
}
