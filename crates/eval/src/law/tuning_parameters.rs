//! The parameters of the optimal law that are tuned: their names for `--set`, and the ranges of the search.

use anyhow::{Context, Result, bail};
use barrelman_control::optimal::{IntermittentTuning, ModeTuning, Tuning};
use barrelman_experiments::law_choice::ModeName;

/// A parameter: its name, the range that is searched, and its field.
pub(super) type Parameter<T> = (&'static str, (f64, f64), fn(&mut T) -> &mut f64);

/// The parameters of the receding-horizon modes. The names are words of the command line: they stay when a field is renamed.
const RECEDING_HORIZON: [Parameter<Tuning>; 22] = [
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

/// The parameters of the intermittent mode.
const INTERMITTENT: [Parameter<IntermittentTuning>; 37] = [
    ("start", (0.8, 1.5), |t| &mut t.start.base),
    ("start.sway", (-3.0, 1.0), |t| &mut t.start.sway),
    ("start.steepness", (-0.2, 0.2), |t| &mut t.start.steepness),
    ("start.usual_rate", (-1.0, 1.0), |t| &mut t.start.usual_rate),
    ("start.delay", (-1.0, 1.0), |t| &mut t.start.delay),
    ("start.lag", (-2.0, 2.0), |t| &mut t.start.lag),
    ("start_look_ahead_s", (-0.2, 1.4), |t| &mut t.start_look_ahead_s),
    ("stop", (0.3, 1.0), |t| &mut t.stop.base),
    ("stop.sway", (-3.0, 3.0), |t| &mut t.stop.sway),
    ("stop.steepness", (-0.3, 0.3), |t| &mut t.stop.steepness),
    ("stop.usual_rate", (-2.0, 2.0), |t| &mut t.stop.usual_rate),
    ("stop.delay", (-1.0, 1.0), |t| &mut t.stop.delay),
    ("stop.lag", (-2.0, 2.0), |t| &mut t.stop.lag),
    ("stop_look_ahead_s", (0.0, 3.0), |t| &mut t.stop_look_ahead_s),
    ("aim", (0.1, 0.9), |t| &mut t.aim),
    ("aim_look_ahead_s", (0.0, 4.0), |t| &mut t.aim_look_ahead_s),
    ("horizon_s", (0.6, 3.0), |t| &mut t.horizon_s),
    ("cruise_rate", (0.15, 0.34), |t| &mut t.cruise_rate.base),
    ("cruise_rate.sway", (-1.0, 1.0), |t| &mut t.cruise_rate.sway),
    ("cruise_rate.steepness", (-0.1, 0.1), |t| &mut t.cruise_rate.steepness),
    ("cruise_rate.usual_rate", (-0.5, 0.5), |t| &mut t.cruise_rate.usual_rate),
    ("cruise_rate.delay", (-0.5, 0.5), |t| &mut t.cruise_rate.delay),
    ("cruise_rate.lag", (-1.0, 1.0), |t| &mut t.cruise_rate.lag),
    ("max_rate", (0.25, 0.4), |t| &mut t.max_rate),
    ("join_share", (0.2, 1.01), |t| &mut t.join_share),
    ("leave_share", (0.0, 0.8), |t| &mut t.leave_share),
    ("start_response_share", (0.0, 1.4), |t| &mut t.start_response_share),
    ("stop_response_share", (0.0, 1.4), |t| &mut t.stop_response_share),
    ("correction", (0.3, 1.3), |t| &mut t.correction),
    ("min_rest_s", (0.0, 0.8), |t| &mut t.min_rest_s),
    ("return_time_s", (1.5, 20.0), |t| &mut t.return_time_s),
    ("memory_s", (5.0, 120.0), |t| &mut t.memory_s),
    ("rate_std_dev", (0.05, 0.3), |t| &mut t.noise.rate_std_dev),
    ("rate_time_constant_s", (0.5, 6.0), |t| &mut t.noise.rate_time_constant_s),
    ("measurement_std_dev", (0.0005, 0.03), |t| &mut t.noise.measurement_std_dev),
    ("max_sway_std_dev", (0.0, 0.15), |t| &mut t.noise.max_sway_std_dev),
    ("sway_time_constant_s", (0.3, 8.0), |t| &mut t.noise.sway_time_constant_s),
];

/// A mode's name in the tables, and its tuning.
pub(super) fn of_mode(mode: ModeName) -> (&'static str, ModeTuning) {
    match mode {
        ModeName::MinimumEnergy => ("minimum-energy", Tuning::MINIMUM_ENERGY.into()),
        ModeName::TimeFuel => ("time-fuel", Tuning::TIME_FUEL.into()),
        ModeName::Eco => ("eco", Tuning::ECO.into()),
        ModeName::Intermittent => ("intermittent", IntermittentTuning::DEFAULT.into()),
    }
}

/// A tuning with some of its values changed, each NAME=VALUE.
///
/// # Errors
/// If there is no parameter of that name, or the value is not a number.
pub(super) fn with_changes(tuning: ModeTuning, changes: &[String]) -> Result<ModeTuning> {
    Ok(match tuning {
        ModeTuning::RecedingHorizon(tuning) => changed(tuning, &RECEDING_HORIZON, changes)?.into(),
        ModeTuning::Intermittent(tuning) => changed(tuning, &INTERMITTENT, changes)?.into(),
    })
}

fn changed<T>(mut tuning: T, parameters: &[Parameter<T>], changes: &[String]) -> Result<T> {
    for change in changes {
        let (name, value) = change.split_once('=').with_context(|| format!("{change}: write NAME=VALUE"))?;
        let (_, _, field) = parameter(parameters, name)?;
        *field(&mut tuning) = value.parse().with_context(|| format!("{change}: {value} is not a number"))?;
    }
    Ok(tuning)
}

/// Checks that a mode has parameters of these names.
///
/// # Errors
/// If there is no parameter of a name.
pub(super) fn check_names(mode: ModeName, names: &[String]) -> Result<()> {
    names.iter().try_for_each(|name| match of_mode(mode).1 {
        ModeTuning::RecedingHorizon(_) => parameter(&RECEDING_HORIZON, name).map(drop),
        ModeTuning::Intermittent(_) => parameter(&INTERMITTENT, name).map(drop),
    })
}

/// The parameter of this name.
fn parameter<'a, T>(parameters: &'a [Parameter<T>], name: &str) -> Result<&'a Parameter<T>> {
    let Some(parameter) = parameters.iter().find(|(known, ..)| *known == name) else {
        let known: Vec<&str> = parameters.iter().map(|(name, ..)| *name).collect();
        bail!("unknown value {name}; known are {}", known.join(", "));
    };
    Ok(parameter)
}

/// A tuning with a few values changed at random, by at most `step` of their ranges: `mean_changes` values on average, of
/// those in `vary` if any are given. `random` gives uniform deviates in [0, 1) by their index.
pub(super) fn mutated(
    tuning: ModeTuning,
    vary: &[String],
    step: f64,
    mean_changes: f64,
    random: impl Fn(u64) -> f64,
) -> ModeTuning {
    match tuning {
        ModeTuning::RecedingHorizon(tuning) => {
            mutated_parameters(tuning, &RECEDING_HORIZON, vary, step, mean_changes, random).into()
        }
        ModeTuning::Intermittent(tuning) => {
            mutated_parameters(tuning, &INTERMITTENT, vary, step, mean_changes, random).into()
        }
    }
}

fn mutated_parameters<T>(
    mut tuning: T,
    parameters: &[Parameter<T>],
    vary: &[String],
    step: f64,
    mean_changes: f64,
    random: impl Fn(u64) -> f64,
) -> T {
    let is_varied = |name: &str| vary.is_empty() || vary.iter().any(|chosen| chosen == name);
    let varied = parameters.iter().filter(|(name, ..)| is_varied(name)).count();
    for (index, (name, (low, high), field)) in (1_u64..).zip(parameters) {
        if is_varied(name) && random(2 * index) < mean_changes / varied as f64 {
            let value = field(&mut tuning);
            *value = (*value + step * (high - low) * (2.0 * random(2 * index + 1) - 1.0)).clamp(*low, *high);
        }
    }
    tuning
}

/// The options `--set NAME=VALUE` that give a tuning.
pub(super) fn to_options(tuning: ModeTuning) -> String {
    match tuning {
        ModeTuning::RecedingHorizon(tuning) => options(tuning, &RECEDING_HORIZON),
        ModeTuning::Intermittent(tuning) => options(tuning, &INTERMITTENT),
    }
}

fn options<T>(mut tuning: T, parameters: &[Parameter<T>]) -> String {
    let options: Vec<String> =
        parameters.iter().map(|(name, _, field)| format!("--set {name}={:.5}", field(&mut tuning))).collect();
    options.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_lies_within_the_searched_ranges() {
        fn check<T>(mut tuning: T, parameters: &[Parameter<T>]) {
            for (name, (low, high), field) in parameters {
                let value = *field(&mut tuning);
                assert!((*low..=*high).contains(&value), "{name}: {value} is not in {low} to {high}");
            }
        }
        for tuning in [Tuning::MINIMUM_ENERGY, Tuning::TIME_FUEL, Tuning::ECO] {
            check(tuning, &RECEDING_HORIZON);
        }
        check(IntermittentTuning::DEFAULT, &INTERMITTENT);
    }
}
