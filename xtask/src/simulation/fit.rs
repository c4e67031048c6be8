//! Fits how the simulated target moves to how the recorded targets moved.
//!
//! What is compared are the means over trials of [`motion::STATISTICS`], and the spread of the trials' lengths and
//! speeds, each in standard errors of the recorded means, or in twentieths of the mean where those are smaller: the
//! script is no person. What is changed is how fast the target goes, how that varies, how much it slows down where it
//! turns, and how long it stands; how it steers along its path is the study's, and plant, optics, sway and noise stay.
//! Candidates are drawn around the best one so far, closer and closer, from a fixed seed: the same call gives the same
//! fit. Seeds from 1 on are used; none from 10,000 on.

use std::path::Path;

use anyhow::Result;
use barrelman_sim::pursuit::PursuitScript;
use barrelman_sim::scenario::TargetScript;
use barrelman_sim::{Scenario, noise};

use super::motion::{self, STATISTICS};
use super::recorded::{read, scenario, simulated};
use crate::say;

/// A parameter of the script: its name in the scenario's file, its bounds, and where it stands.
type Parameter = (&'static str, f64, f64, fn(&mut PursuitScript) -> &mut f64);

const PARAMETERS: [Parameter; 9] = [
    ("corner_slow_down", 0.0, 0.95, |s| &mut s.corner_slow_down),
    ("speed_m_per_s", 0.5, 3.0, |s| &mut s.speed_m_per_s),
    ("speed_spread", 0.05, 0.5, |s| &mut s.speed_spread),
    ("gust_share", 0.0, 1.0, |s| &mut s.gust.deviation),
    ("gust_time_s", 0.5, 5.0, |s| &mut s.gust.time_s),
    ("stand_before_s", 0.0, 6.0, |s| &mut s.stand_before_s),
    ("stand_after_s", 0.0, 3.0, |s| &mut s.stand_after_s),
    ("pauses_per_s", 0.0, 0.5, |s| &mut s.pauses_per_s),
    ("pause_s", 0.2, 3.0, |s| &mut s.pause_s),
];

/// Statistics and the spreads of length and median speed.
const COMPARED: usize = STATISTICS.len() + 2;

/// How far the bearing moves over seconds is the path's doing, which is given: it is shown, not fitted.
const GEOMETRY: core::ops::Range<usize> = 14..22;
/// No closer agreement than to this share is asked for.
const SCRIPT_ERROR: f64 = 0.05;

/// Means over trials, and what of the spreads is compared.
fn summary(motions: &[motion::Motion]) -> [f64; COMPARED] {
    let count = motions.len() as f64;
    let mean = |index: usize| motions.iter().map(|m| m.values[index]).sum::<f64>() / count;
    let spread = |index: usize| {
        let mean = mean(index);
        let squares: f64 = motions.iter().map(|m| (m.values[index] / mean - 1.0).powi(2)).sum();
        (squares / (count - 1.0)).sqrt()
    };
    let mut all = [0.0; COMPARED];
    for (index, slot) in all.iter_mut().take(STATISTICS.len()).enumerate() {
        *slot = mean(index);
    }
    all[STATISTICS.len()] = spread(0);
    all[STATISTICS.len() + 1] = spread(3);
    all
}

/// Standard errors of a summary: of the means from the trials, of the spreads by their usual formula.
fn errors(motions: &[motion::Motion], summary: &[f64; COMPARED]) -> [f64; COMPARED] {
    let count = motions.len() as f64;
    let mut errors = [0.0; COMPARED];
    for index in 0..STATISTICS.len() {
        let squares: f64 = motions.iter().map(|m| (m.values[index] - summary[index]).powi(2)).sum();
        errors[index] = (squares / (count - 1.0) / count).sqrt().max(SCRIPT_ERROR * summary[index]);
    }
    for index in STATISTICS.len()..COMPARED {
        errors[index] = summary[index] / (2.0 * (count - 1.0)).sqrt();
    }
    errors
}

/// Fits, and prints the values for the scenario's file.
pub(super) fn run(folder: &Path, arena: u8, rounds: u64, seeds: u64) -> Result<bool> {
    let scenario = scenario(arena)?;
    let recorded: Vec<_> =
        read(folder, arena, false)?.iter().map(|trial| motion::of(&trial.log, &scenario)).collect();
    let wanted = summary(&recorded);
    let errors = errors(&recorded, &wanted);
    let TargetScript::Pursuit(start) = scenario.target.clone() else {
        anyhow::bail!("the target of {} does not pursue a path", scenario.name);
    };
    let judge = |script: &PursuitScript| -> Result<(f64, [f64; COMPARED])> {
        let scenario = Scenario { target: TargetScript::Pursuit(script.clone()), ..scenario.clone() };
        let motions: Vec<_> = (1..=seeds)
            .map(|seed| Ok(motion::of(&simulated(&scenario, seed)?, &scenario)))
            .collect::<Result<_>>()?;
        let found = summary(&motions);
        let misfit = (0..COMPARED)
            .filter(|index| !GEOMETRY.contains(index))
            .map(|index| ((found[index] - wanted[index]) / errors[index]).powi(2))
            .sum();
        Ok((misfit, found))
    };
    let mut best = (judge(&start)?, start);
    say(&format!("start: misfit {:.1}", best.0.0));
    for round in 0..rounds {
        let reach = 0.5 * (0.02_f64).powf(round as f64 / rounds as f64);
        let mut script = best.1.clone();
        for (index, (_, low, high, of)) in PARAMETERS.iter().enumerate() {
            // Some parameters of each candidate stay as they are.
            if noise::unit(1, round, 2 * index as u64) < 0.6 {
                continue;
            }
            let value = of(&mut script);
            *value = (*value + reach * (high - low) * noise::normal(1, round, 100 + index as u64))
                .clamp(*low, *high);
        }
        let judged = judge(&script)?;
        if judged.0 < best.0.0 {
            say(&format!("round {round}: misfit {:.1}", judged.0));
            best = (judged, script);
        }
    }
    let ((misfit, found), mut script) = best;
    say(&format!(
        "\nmisfit {misfit:.1} over {COMPARED} figures\n{:32} {:>10} {:>8} {:>10}",
        "", "recorded", "+-", "simulated"
    ));
    let names = STATISTICS.iter().copied().chain(["spread of length", "spread of median speed"]);
    for (index, name) in names.enumerate() {
        say(&format!("{name:32} {:>10.3} {:>8.3} {:>10.3}", wanted[index], errors[index], found[index]));
    }
    say("\n[target]");
    for (name, _, _, of) in PARAMETERS {
        say(&format!("{name} = {:.3}", *of(&mut script)));
    }
    Ok(true)
}
