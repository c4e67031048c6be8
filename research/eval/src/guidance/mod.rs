//! Compares our guidance law with the laboratory's: the same seeds, arrival circle, throttle limit and frame
//! rate.
//!
//! A camera at rest, 15 m above the water, looks down by 40 degrees; the boat goes 13 to 25 m from a start to
//! a place or a person in the picture. Both laws see pixels with 2 px of noise after the latency. The
//! laboratory's law computes a step for each video frame. `--loop` compares them in the whole loop instead
//! ([`whole_loop`]).

mod condition;
mod course;
mod gains;
mod requirements;
mod summary;
mod trial;
mod whole_loop;

use std::time::Duration;

use anyhow::Result;
use barrelman_control::guidance::{LabSettings, LineOfSightTuning, VesselLimits, VesselModel};
use clap::Args;

use crate::output::print_line;
use crate::parallel;
use condition::{CONDITIONS, Condition};
use requirements::Requirements;
use summary::{Ratios, arrivals, least_clearance, mean_of, mean_of_arrived};
use trial::{ARRIVAL_M, KEEP_OUT_M, LawUnderTest, NOISE_PX, Outcome, STAND_OFF_M};

/// Options of `guidance`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Trials of each condition.
    #[arg(long, value_name = "N", default_value_t = 60)]
    seeds: u64,
    /// The first seed. Those below 10,000 were used for tuning.
    #[arg(long, value_name = "SEED", default_value_t = 40_000)]
    first_seed: u64,
    /// Only the conditions whose name begins so.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Print each trial.
    #[arg(long, conflicts_with = "whole_loop")]
    each: bool,
    /// Another value of one of our law's gains, for tuning: NAME=VALUE.
    #[arg(long, value_name = "NAME=VALUE", conflicts_with = "whole_loop")]
    set: Vec<String>,
    /// The whole loop instead: a swaying kite whose camera follows the boat, and an operator who marks the
    /// people.
    #[arg(long = "loop")]
    whole_loop: bool,
}

/// A law with its name in the table.
struct NamedLaw {
    name: &'static str,
    law: LawUnderTest,
    /// Whether the requirements hold for this law.
    is_judged: bool,
}

/// Prints the table. Returns whether every requirement holds.
///
/// # Errors
/// If a scenario cannot be loaded.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let is_met = if options.whole_loop { run_whole_loop(options)? } else { run_laws(options)? };
    print_line(if is_met { "\nevery requirement holds" } else { "\nrequirements are MISSED" });
    Ok(is_met)
}

impl Options {
    fn wants(&self, name: &str) -> bool {
        self.only.as_ref().is_none_or(|only| name.starts_with(only.as_str()))
    }

    fn seeds(&self) -> Vec<u64> {
        (self.first_seed..self.first_seed + self.seeds).collect()
    }
}

fn run_whole_loop(options: &Options) -> Result<bool> {
    print_line(&format!(
        "{} trials a condition, seeds from {}; truth with 2 px of noise, 15 frames/s; the operator marks people with up to 4 px \
         of error, and moves the marks every 5 s",
        options.seeds, options.first_seed
    ));
    print_line(whole_loop::HEADER);
    let mut is_met = true;
    for condition in whole_loop::CONDITIONS.iter().filter(|condition| options.wants(condition.name())) {
        print_line(&format!("\n{}", condition.name()));
        is_met &= whole_loop::compare(condition, &options.seeds())?;
    }
    Ok(is_met)
}

fn run_laws(options: &Options) -> Result<bool> {
    print_line(&format!(
        "{} trials a condition, seeds from {}; {NOISE_PX} px of noise; arrival circle {} m around a place, {} m around a \
         person; stand-off {STAND_OFF_M} m, keep-out {KEEP_OUT_M} m",
        options.seeds, options.first_seed, ARRIVAL_M.0, ARRIVAL_M.1
    ));
    print_line(
        "law                  arrived  time s  cross-track m  path/way  rudder/s  clearance m  held m   \
         ratios to the lab's law, 95 %: cross-track, time, rudder",
    );
    let tuning = gains::changed(&options.set)?;
    let mut is_met = true;
    for condition in CONDITIONS.iter().filter(|condition| options.wants(condition.name)) {
        print_line(&format!("\n{}", condition.describe()));
        is_met &= compare(condition, options, tuning)?;
    }
    Ok(is_met)
}

/// The laws of a condition, the laboratory's first.
fn laws((tuning, model): (LineOfSightTuning, VesselModel)) -> [NamedLaw; 3] {
    // A step for each video frame that arrives.
    let lab = LabSettings { interval: Duration::ZERO, ..LabSettings::PAPER };
    let ours =
        |ahead| LawUnderTest::LineOfSight(tuning, model, VesselLimits { ahead, ..VesselLimits::DEFAULT });
    [
        NamedLaw { name: "lab, throttle 0.6", law: LawUnderTest::Lab(lab), is_judged: false },
        NamedLaw { name: "ours, throttle 0.6", law: ours(0.6), is_judged: true },
        NamedLaw { name: "ours, throttle 0.7", law: ours(0.7), is_judged: false },
    ]
}

fn compare(
    condition: &Condition,
    options: &Options,
    (tuning, model): (LineOfSightTuning, VesselModel),
) -> Result<bool> {
    let base = condition.scenario()?;
    let seeds = options.seeds();
    let mut lab: Vec<Outcome> = Vec::new();
    let mut is_met = true;
    for NamedLaw { name, law, is_judged } in laws((tuning, model)) {
        let outcomes: Vec<Outcome> = parallel::map(&seeds, |seed| trial::run(condition, &base, law, *seed))
            .into_iter()
            .collect::<Result<_>>()?;
        if options.each {
            for (seed, outcome) in seeds.iter().zip(&outcomes) {
                print_line(&format!("{seed} {outcome:?}"));
            }
        }
        let ratios = (!lab.is_empty()).then(|| Ratios::new(&lab, &outcomes));
        let missed = match &ratios {
            Some(ratios) if is_judged => Requirements::of(condition).missed(&outcomes, ratios),
            _ => Vec::new(),
        };
        is_met &= missed.is_empty();
        print_line(&format!(
            "{name:20} {:>7}  {:>6}  {:>13}  {:>8}  {:>8}  {:>11}  {:>6}   {}{}",
            format!("{}/{}", arrivals(&outcomes), outcomes.len()),
            cell(mean_of_arrived(&outcomes, |outcome| outcome.arrived_s), 1),
            cell(mean_of(&outcomes, |outcome| outcome.cross_track_m), 3),
            cell(mean_of(&outcomes, |outcome| outcome.path_ratio), 2),
            cell(mean_of(&outcomes, |outcome| outcome.rudder_per_s), 2),
            cell(least_clearance(&outcomes), 2),
            cell(mean_of(&outcomes, |outcome| outcome.held_m), 2),
            ratios.map_or_else(String::new, |ratios| ratios.cells()),
            missed.iter().map(|what| format!("  MISSED: {what}")).collect::<String>(),
        ));
        if lab.is_empty() {
            lab = outcomes;
        }
    }
    Ok(is_met)
}

/// A number with this many decimals; a dash where it is not finite.
fn cell(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { "-".to_owned() }
}
