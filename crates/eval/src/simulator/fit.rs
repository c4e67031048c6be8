//! Fits how the simulated target moves to how the recorded targets moved.
//!
//! What is compared are the means over trials of [`motion::STATISTICS`], and the spread of some of them
//! over the trials, each in standard errors of the recorded means, or in twentieths of the mean where those are smaller: the
//! script is no person. Statistics that say nearly the same count as one together: the quantiles of the speed as much
//! as the trial's length. A statistic that the script cannot meet at all must not decide about the others: from
//! [`BEND`] errors on its misfit grows in proportion only (Huber's loss). P, the region and excursions are not
//! looked at.
//!
//! What is changed is how fast the target goes, how that varies, how much it slows down where it turns and where it
//! arrives, how closely it keeps to its path, how long it stands, how far away the path lies and how broad it is;
//! plant, optics, sway and noise stay.
//!
//! The search is an evolution strategy with a variance for each parameter (CMA-ES with a diagonal covariance, Ros and
//! Hansen 2008), begun several times from different places, all draws from a fixed seed: the same call gives the same
//! fit. All candidates meet the same seeds, all below 10,000, chosen so that the trials' speeds and standing are spread
//! as many trials' are: a few dozen seeds in a row may happen to be slow, and a fit to those is too fast for the rest.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use barrelman_experiments::campaign::runner::run_in_order;
use barrelman_sim::pursuit::{Pursuit, PursuitScript};
use barrelman_sim::scenario::TargetScript;
use barrelman_sim::{Scenario, noise};

use super::FitOptions;
use super::motion::{self, COUNT, STATISTICS};
use super::recorded::{read, scenario, simulated};
use crate::say;

/// A parameter of the script: its name in the scenario's file, its bounds, and where it stands.
type Parameter = (&'static str, f64, f64, fn(&mut Script) -> &mut f64);

/// The script, and by what its path is stretched in addition: as a whole, and across.
#[derive(Debug, Clone)]
struct Script {
    pursuit: PursuitScript,
    scale: f64,
    breadth: f64,
}

impl Script {
    fn stretched(&self) -> PursuitScript {
        let stretched = |(x, y): &(f64, f64)| (self.scale * self.breadth * x, self.scale * y);
        let way_points = self.pursuit.way_points.iter().map(stretched).collect();
        PursuitScript { way_points, ..self.pursuit.clone() }
    }
}

const PARAMETERS: [Parameter; 20] = [
    ("scale", 0.6, 1.4, |s| &mut s.scale),
    ("breadth", 0.6, 1.4, |s| &mut s.breadth),
    ("speed_m_per_s", 0.5, 3.0, |s| &mut s.pursuit.speed_m_per_s),
    ("speed_spread", 0.05, 0.4, |s| &mut s.pursuit.log_speed_std_dev),
    ("range_exponent", 0.0, 1.0, |s| &mut s.pursuit.range_exponent),
    ("gust_share", 0.0, 0.8, |s| &mut s.pursuit.speed_variation.std_dev),
    ("gust_time_s", 0.1, 5.0, |s| &mut s.pursuit.speed_variation.time_constant_s),
    ("weave_rad", 0.0, 1.0, |s| &mut s.pursuit.weave.std_dev),
    ("weave_time_s", 0.2, 3.0, |s| &mut s.pursuit.weave.time_constant_s),
    ("look_ahead_m", 0.15, 1.0, |s| &mut s.pursuit.look_ahead_m),
    ("way_point_jitter_m", 0.0, 0.4, |s| &mut s.pursuit.way_point_jitter_m),
    ("surge_lag_s", 0.02, 1.0, |s| &mut s.pursuit.surge_lag_s),
    ("corner_slow_down", 0.0, 0.95, |s| &mut s.pursuit.corner_slow_down),
    ("arrival_m", 0.0, 3.0, |s| &mut s.pursuit.arrival_m),
    ("stand_before_s", 0.0, 15.0, |s| &mut s.pursuit.stand_before_s),
    ("stand_after_s", 0.0, 3.0, |s| &mut s.pursuit.stand_after_s),
    ("pauses_per_s", 0.0, 0.5, |s| &mut s.pursuit.pauses_per_s),
    ("leg_rhythm", 0.0, 0.95, |s| &mut s.pursuit.leg_end_slow_down),
    ("corner_pauses", 0.0, 1.0, |s| &mut s.pursuit.corner_pauses),
    ("pause_s", 0.2, 3.0, |s| &mut s.pursuit.pause_s),
];

/// A place in the space of parameters, each from 0 at its lower bound to 1 at its upper one.
type Place = [f64; PARAMETERS.len()];

/// Statistics and spreads.
const COMPARED: usize = COUNT + SPREADS.len();
/// No closer agreement than to this share is asked for.
const SCRIPT_ERROR: f64 = 0.05;
/// From so many errors on the misfit grows in proportion only.
const BEND: f64 = 3.0;
/// Statistics whose spread over the trials is compared too.
const SPREADS: [(usize, &str); 5] = [
    (0, "spread of length"),
    (3, "spread of speed, 50 %"),
    (5, "spread of speed, 90 %"),
    (9, "spread of speed across, 90 %"),
    (43, "spread of azimuth over 4 s"),
];

/// Where groups of statistics end that say nearly the same in different ways, such as the quantiles of the speed: a group
/// counts as one figure, the mean of its losses.
const GROUPS: [usize; 15] = [1, 8, 14, 17, 19, 22, 24, 26, 35, 41, 45, 49, 53, COUNT, COMPARED];

/// Means over trials, and what of the spreads is compared.
fn summary(motions: &[motion::Motion]) -> [f64; COMPARED] {
    let count = motions.len() as f64;
    let mean = |index: usize| motions.iter().map(|m| m.values[index]).sum::<f64>() / count;
    let spread = |index: usize| {
        let mean = mean(index);
        let squares: f64 = motions.iter().map(|m| (m.values[index] / mean - 1.0).powi(2)).sum();
        (squares / (count - 1.0)).sqrt()
    };
    std::array::from_fn(|index| if index < COUNT { mean(index) } else { spread(SPREADS[index - COUNT].0) })
}

/// Standard errors of a summary: of the means from the trials, of the spreads by their usual formula.
fn errors(motions: &[motion::Motion], summary: &[f64; COMPARED]) -> [f64; COMPARED] {
    let count = motions.len() as f64;
    std::array::from_fn(|index| {
        if index >= COUNT {
            return summary[index] / (2.0 * (count - 1.0)).sqrt();
        }
        let squares: f64 = motions.iter().map(|m| (m.values[index] - summary[index]).powi(2)).sum();
        (squares / (count - 1.0) / count).sqrt().max(SCRIPT_ERROR * summary[index].abs())
    })
}

/// Huber's loss of a difference in errors.
fn loss(errors: f64) -> f64 {
    let errors = errors.abs();
    if errors <= BEND { errors * errors } else { BEND * (2.0 * errors - BEND) }
}

/// What the recorded trials want, and how candidates are judged.
struct Judge {
    scenario: Scenario,
    start: Script,
    wanted: [f64; COMPARED],
    errors: [f64; COMPARED],
    seeds: Vec<u64>,
}

/// Seeds below [`SEEDS_END`] whose trials stand for all: of strata by speed that are equally likely one seed each, and
/// their standing spread evenly, too.
fn representative(count: u64) -> Vec<u64> {
    let mut by_speed: Vec<u64> = (1..SEEDS_END).collect();
    by_speed.sort_by(|a, b| Pursuit::sampled_pace(*a).0.total_cmp(&Pursuit::sampled_pace(*b).0));
    let size = by_speed.len() as f64 / count as f64;
    (0..count)
        .map(|stratum| {
            let from = (stratum as f64 * size) as usize;
            // A share that no two strata have in common and that does not go with the speed.
            let share = (stratum as f64 * GOLDEN).fract();
            let middle = from + (0.5 * size) as usize;
            let off = |seed: u64| ((1.0 - (-Pursuit::sampled_pace(seed).1).exp()) - share).abs();
            by_speed[from..]
                .iter()
                .take(size as usize)
                .copied()
                .min_by(|a, b| off(*a).total_cmp(&off(*b)))
                .unwrap_or(by_speed[middle])
        })
        .collect()
}

/// No seed from here on is used.
const SEEDS_END: u64 = 10_000;
/// Multiples of it spread most evenly between whole numbers.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Judge {
    fn script(&self, place: &Place) -> Script {
        let mut script = self.start.clone();
        for ((_, low, high, of), share) in PARAMETERS.iter().zip(place) {
            *of(&mut script) = low + (high - low) * share;
        }
        script
    }

    fn place(&self, script: &Script) -> Place {
        let mut script = script.clone();
        PARAMETERS.map(|(_, low, high, of)| ((*of(&mut script) - low) / (high - low)).clamp(0.0, 1.0))
    }

    fn found(&self, place: &Place) -> Result<[f64; COMPARED]> {
        let target = TargetScript::Pursuit(self.script(place).stretched());
        let scenario = Scenario { target, ..self.scenario.clone() };
        let motions: Vec<_> = self
            .seeds
            .iter()
            .map(|seed| Ok(motion::of(&simulated(&scenario, *seed)?, &scenario)))
            .collect::<Result<_>>()?;
        Ok(summary(&motions))
    }

    fn misfit(&self, found: &[f64; COMPARED]) -> f64 {
        let loss = |index: usize| loss((found[index] - self.wanted[index]) / self.errors[index]);
        let mut first = 0;
        GROUPS
            .iter()
            .map(|end| {
                let group = core::mem::replace(&mut first, *end)..*end;
                let size = group.len() as f64;
                group.map(loss).sum::<f64>() / size
            })
            .sum()
    }
}

/// Candidates of a generation, and how many of them the next one is drawn around.
const CANDIDATES: usize = 16;
const PARENTS: usize = CANDIDATES / 2;

/// An evolution strategy with a variance for each parameter.
struct Strategy {
    mean: Place,
    step: f64,
    deviations: Place,
    path_of_step: Place,
    path_of_variance: Place,
    stream: u64,
    generation: u64,
}

impl Strategy {
    fn around(mean: Place, step: f64, stream: u64) -> Self {
        let zeros = [0.0; PARAMETERS.len()];
        Self {
            mean,
            step,
            deviations: [1.0; PARAMETERS.len()],
            path_of_step: zeros,
            path_of_variance: zeros,
            stream,
            generation: 0,
        }
    }

    fn candidates(&self) -> Vec<Place> {
        (0..CANDIDATES as u64)
            .map(|candidate| {
                std::array::from_fn(|index| {
                    let draw = (self.generation * CANDIDATES as u64 + candidate) * 64 + index as u64;
                    let off = self.step * self.deviations[index] * noise::normal(7, self.stream, draw);
                    (self.mean[index] + off).clamp(0.0, 1.0)
                })
            })
            .collect()
    }

    /// Takes candidates in the order of their misfits.
    fn learn(&mut self, best_first: &[Place]) {
        let n = PARAMETERS.len() as f64;
        let raw: [f64; PARENTS] =
            std::array::from_fn(|rank| (PARENTS as f64 + 0.5).ln() - (rank as f64 + 1.0).ln());
        let sum: f64 = raw.iter().sum();
        let weights = raw.map(|weight| weight / sum);
        let effective = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let keep_step = (effective + 2.0) / (n + effective + 3.0);
        let damping = 1.0 + 2.0 * ((effective - 1.0) / (n + 1.0)).sqrt().max(1.0) - 2.0 + keep_step;
        let keep_path = 4.0 / (n + 4.0);
        // A diagonal has fewer values to learn than a whole matrix, so that it learns faster.
        let faster = (n + 1.5) / 3.0;
        let of_path = (faster * 2.0 / ((n + 1.3).powi(2) + effective)).min(0.5);
        let of_parents =
            (faster * 2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0).powi(2) + effective)).min(0.4);
        let before = self.mean;
        for index in 0..PARAMETERS.len() {
            self.mean[index] =
                weights.iter().zip(best_first).map(|(weight, place)| weight * place[index]).sum();
            let moved = (self.mean[index] - before[index]) / (self.step * self.deviations[index]);
            self.path_of_step[index] = (1.0 - keep_step) * self.path_of_step[index]
                + (keep_step * (2.0 - keep_step) * effective).sqrt() * moved;
            let moved = moved * self.deviations[index];
            self.path_of_variance[index] = (1.0 - keep_path) * self.path_of_variance[index]
                + (keep_path * (2.0 - keep_path) * effective).sqrt() * moved;
            let spread: f64 = weights
                .iter()
                .zip(best_first)
                .map(|(weight, place)| weight * ((place[index] - before[index]) / self.step).powi(2))
                .sum();
            let variance = (1.0 - of_path - of_parents) * self.deviations[index].powi(2)
                + of_path * self.path_of_variance[index].powi(2)
                + of_parents * spread;
            self.deviations[index] = variance.max(1.0e-6).sqrt();
        }
        let length: f64 = self.path_of_step.iter().map(|value| value * value).sum::<f64>().sqrt();
        let expected = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
        self.step *= (keep_step / damping * (length / expected - 1.0)).exp();
        self.step = self.step.clamp(1.0e-3, 0.5);
        self.generation += 1;
    }
}

/// Fits, and prints the values for the scenario's file.
pub(super) fn run(folder: &Path, options: &FitOptions) -> Result<bool> {
    let scenario = scenario(options.arena, options.scenarios.as_deref())?;
    let recorded: Vec<_> =
        read(folder, options.arena, false)?.iter().map(|trial| motion::of(&trial.log, &scenario)).collect();
    let wanted = summary(&recorded);
    let TargetScript::Pursuit(pursuit) = scenario.target.clone() else {
        anyhow::bail!("the target of {} does not pursue a path", scenario.name);
    };
    let judge = Judge {
        errors: errors(&recorded, &wanted),
        wanted,
        scenario,
        start: Script { pursuit, scale: 1.0, breadth: 1.0 },
        seeds: representative(options.seeds),
    };
    let start = judge.place(&judge.start);
    let mut best = (judge.misfit(&judge.found(&start)?), start);
    say(&format!("as it is: misfit {:.1}", best.0));
    for begun in 0..options.starts {
        // The first search begins with what the file has, the others anywhere.
        let place = match begun {
            0 => start,
            _ => std::array::from_fn(|index| noise::unit(8, begun, index as u64)),
        };
        let mut strategy = Strategy::around(place, if begun == 0 { 0.15 } else { 0.3 }, begun);
        let mut least = f64::INFINITY;
        for _ in 0..options.generations {
            let candidates = strategy.candidates();
            let numbers: Vec<u64> = (0..candidates.len() as u64).collect();
            let mut judged = Vec::with_capacity(candidates.len());
            run_in_order(
                &numbers,
                options.threads,
                &AtomicBool::new(false),
                |number| {
                    let place = candidates[number as usize];
                    Ok((judge.misfit(&judge.found(&place)?), place))
                },
                |result| {
                    judged.push(result);
                    Ok(())
                },
            )?;
            judged.sort_by(|a, b| a.0.total_cmp(&b.0));
            let first = *judged.first().context("no candidate was judged")?;
            least = least.min(first.0);
            if first.0 < best.0 {
                best = first;
            }
            let best_first: Vec<Place> = judged.into_iter().map(|(_, place)| place).collect();
            strategy.learn(&best_first);
        }
        say(&format!("search {}: misfit {least:.1}, last step {:.3}", begun + 1, strategy.step));
    }
    let (misfit, place) = best;
    let found = judge.found(&place)?;
    say(&format!(
        "\nmisfit {misfit:.1} over {} groups of figures\n{:32} {:>10} {:>8} {:>10} {:>8}",
        GROUPS.len(),
        "",
        "recorded",
        "+-",
        "simulated",
        "errors"
    ));
    let names = STATISTICS.iter().copied().chain(SPREADS.map(|(_, name)| name));
    for (index, name) in names.enumerate() {
        let (wanted, error, found) = (judge.wanted[index], judge.errors[index], found[index]);
        say(&format!(
            "{name:32} {wanted:>10.3} {error:>8.3} {found:>10.3} {:>+8.1}",
            (found - wanted) / error
        ));
    }
    let mut script = judge.script(&place);
    say("\n[target], its scale and its breadth to be multiplied with the file's");
    for (name, _, _, of) in PARAMETERS {
        say(&format!("{name} = {:.3}", *of(&mut script)));
    }
    Ok(true)
}
