//! Searches for a tuning of the optimal law, on seeds that it is never judged on.
//!
//! A random walk: each round changes a few values of the best tuning so far, and keeps the change where it costs less.
//! The cost counts by how much each requirement's ratio lies above its limit less a margin, and, much less, time outside
//! and energy themselves.

use anyhow::{Context, Result, bail};
use barrelman_control::optimal::Tuning;
use barrelman_sim::noise;
use barrelman_station::law_choice::ModeName;
use barrelman_trial::campaign::compare::{METRICS, Metric};
use barrelman_trial::metrics::{TrialEntry, TrialMetrics};

use super::TuneOptions;
use super::conditions::{CONDITIONS, Condition, Subject, trials};
use super::table::limit;
use crate::say;

/// A value that is tuned: its name, its range, and where it is.
type Knob = (&'static str, (f64, f64), fn(&mut Tuning) -> &mut f64);

const KNOBS: [Knob; 22] = [
    ("start", (0.7, 1.1), |t| &mut t.start),
    ("doubt", (0.0, 2.0), |t| &mut t.doubt),
    ("stop", (0.0, 1.0), |t| &mut t.stop),
    ("aim", (0.2, 1.0), |t| &mut t.aim),
    ("horizon_s", (0.6, 3.0), |t| &mut t.horizon_s),
    ("start_ahead_s", (0.0, 2.5), |t| &mut t.start_ahead_s),
    ("stop_ahead_s", (0.0, 2.0), |t| &mut t.stop_ahead_s),
    ("drift_s", (2.0, 30.0), |t| &mut t.drift_s),
    ("least_rate", (0.01, 0.3), |t| &mut t.least_rate),
    ("most_rate", (0.2, 0.4), |t| &mut t.most_rate),
    ("least_share", (0.0, 0.9), |t| &mut t.least_share),
    ("least_rest_s", (0.0, 0.6), |t| &mut t.least_rest_s),
    ("noise.rate", (0.05, 0.3), |t| &mut t.noise.rate),
    ("noise.memory_s", (0.5, 6.0), |t| &mut t.noise.memory_s),
    ("noise.look", (0.0005, 0.03), |t| &mut t.noise.look),
    ("noise.sway", (0.0, 0.15), |t| &mut t.noise.sway),
    ("noise.sway_memory_s", (0.3, 8.0), |t| &mut t.noise.sway_memory_s),
    ("fast", (0.01, 0.5), |t| &mut t.fast),
    ("thrift", (0.0, 3.0), |t| &mut t.thrift),
    ("lazy", (0.0, 3.0), |t| &mut t.lazy),
    ("ease", (0.0, 0.4), |t| &mut t.ease),
    ("hold", (0.0, 0.1), |t| &mut t.hold),
];

/// How far below its limit a ratio is to lie.
const MARGIN: f64 = 0.93;
/// Weight of the logarithms of time outside and energy beside what is required.
const AMBITION: f64 = 0.01;

/// A condition with the schema's figures in it.
struct Judge {
    condition: &'static Condition,
    plan: barrelman_station::campaign::plan::Plan,
    base: Vec<Option<f64>>,
}

/// Searches, and prints what it found.
pub(super) fn run(options: &TuneOptions) -> Result<bool> {
    let (mode, name) = match options.mode {
        ModeName::MinimumEnergy => (Tuning::MINIMUM_ENERGY, "minimum-energy"),
        ModeName::TimeFuel => (Tuning::TIME_FUEL, "time-fuel"),
        ModeName::Eco => (Tuning::ECO, "eco"),
    };
    let judges: Vec<Judge> = CONDITIONS
        .iter()
        // What sways nowhere is nearly as it is indoors; what nothing is required in, only costs time.
        .filter(|condition| {
            let judged = |(figure, _, _): &Metric| limit(condition, name, figure).is_some();
            condition.setting != "still" && METRICS.iter().any(judged)
        })
        .map(|condition| {
            let plan = condition.plan()?;
            let base = means(&trials(&plan, &Subject::Schema, 1, options.seeds)?);
            Ok(Judge { condition, plan, base })
        })
        .collect::<Result<_>>()?;
    let mut best = with(mode, &options.set)?;
    let mut least = cost(&judges, name, &best, options.seeds)?;
    say(&format!("{name}: {least:.5} to begin with"));
    for round in 0..options.rounds {
        let draw = |index: u64| noise::unit(options.search, round, index);
        let mut candidate = best;
        // Now and then a long step, mostly short ones.
        let width = if draw(0) < 0.2 { 0.3 } else { 0.08 };
        for (index, (_, (low, high), at)) in (1_u64..).zip(&KNOBS) {
            if draw(2 * index) < 2.5 / KNOBS.len() as f64 {
                let value = at(&mut candidate);
                *value =
                    (*value + width * (high - low) * (2.0 * draw(2 * index + 1) - 1.0)).clamp(*low, *high);
            }
        }
        let cost = cost(&judges, name, &candidate, options.seeds)?;
        if cost < least {
            (best, least) = (candidate, cost);
            say(&format!("round {round}: {least:.5} {}", in_words(&best)));
        }
    }
    Ok(true)
}

/// A tuning with some of its values changed.
///
/// # Errors
/// If there is no such value, or it is no number.
pub(super) fn with(mut tuning: Tuning, changes: &[String]) -> Result<Tuning> {
    for change in changes {
        let (name, value) = change.split_once('=').with_context(|| format!("{change}: write NAME=VALUE"))?;
        let Some((_, _, at)) = KNOBS.iter().find(|(known, ..)| *known == name) else {
            let known: Vec<&str> = KNOBS.iter().map(|(name, ..)| *name).collect();
            bail!("{name}: there is no such value: it is one of {}", known.join(", "));
        };
        *at(&mut tuning) = value.parse().with_context(|| format!("{change}: {value} is no number"))?;
    }
    Ok(tuning)
}

/// How a tuning is given to `--set`.
fn in_words(tuning: &Tuning) -> String {
    let mut tuning = *tuning;
    let words: Vec<String> =
        KNOBS.iter().map(|(name, _, at)| format!("--set {name}={:.4}", at(&mut tuning))).collect();
    words.join(" ")
}

/// What nobody requires, and what is wanted nevertheless: a camera that rests, too. Where the schema hardly moves at all,
/// its time in motion is no measure.
fn wish(condition: &Condition, mode: &str, figure: &str) -> Option<f64> {
    let wanted = mode == "minimum-energy" && figure == "movement time";
    (wanted && condition.scenario.starts_with("lab")).then_some(4.0)
}

fn means(trials: &[TrialEntry]) -> Vec<Option<f64>> {
    let mean = |of: &fn(&TrialMetrics) -> Option<f64>| {
        let values: Vec<f64> = trials.iter().filter_map(|trial| of(&trial.metrics)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    METRICS.iter().map(|(_, _, of)| mean(of)).collect()
}

fn cost(judges: &[Judge], mode: &str, tuning: &Tuning, seeds: u64) -> Result<f64> {
    let mut cost = 0.0;
    for judge in judges {
        let found = means(&trials(&judge.plan, &Subject::Optimal(*tuning), 1, seeds)?);
        for (((figure, _, _), base), found) in METRICS.iter().zip(&judge.base).zip(found) {
            let (Some(base), Some(found)) = (base, found) else { continue };
            let asked = limit(judge.condition, mode, figure);
            let Some(limit) = asked.or_else(|| wish(judge.condition, mode, figure)) else { continue };
            // Seldom things, such as a lost trial, count from a floor on.
            let ratio = (found + 0.02) / (base + 0.02);
            let above = (ratio / (MARGIN * limit) - 1.0).max(0.0);
            cost += above * above + 0.1 * above;
            if matches!(*figure, "time outside" | "integral of rate squared") {
                cost += AMBITION * logarithm(ratio / limit);
            }
        }
    }
    Ok(cost)
}

fn logarithm(value: f64) -> f64 {
    value.max(1e-3).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_lies_within_what_is_searched() {
        for mut tuning in [Tuning::MINIMUM_ENERGY, Tuning::TIME_FUEL, Tuning::ECO] {
            for (name, (low, high), at) in &KNOBS {
                let value = *at(&mut tuning);
                assert!((*low..=*high).contains(&value), "{name}: {value} is not in {low} to {high}");
            }
        }
    }
}
