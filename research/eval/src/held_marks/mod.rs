//! Measures the marks that trackers hold, in rendered pictures: how far each is from its person, whether it
//! is on another one, and how the boat arrives by them.
//!
//! The scenarios are those with people in the water. The simulated operator marks each person by hand, and
//! moves a mark only while it is not held. The same trials without pictures are printed beside, in which the
//! operator moves all marks every 5 s.

mod judge;

use anyhow::{Context, Result};
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_simd::SimdLevel;
use barrelman_trial::metrics::GuidanceMetrics;
use barrelman_vocab::VesselProfile;
use clap::Args;

use crate::output::print_line;
use crate::parallel;
use judge::{Figures, Judge};

const SCENARIOS: [&str; 5] = ["rescue", "rescue-current", "rescue-surf", "rescue-four", "two-boats"];
/// Least share of the pictures in which a mark is at its person, or says that it is lost.
const HONEST_SHARE: f64 = 0.97;
/// Largest share of the pictures in which a mark is on another person.
const WRONG_SHARE: f64 = 0.005;

/// Options of `held-marks`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Trials of each scenario.
    #[arg(long, value_name = "N", default_value_t = 20)]
    seeds: u64,
    /// The first seed.
    #[arg(long, value_name = "SEED", default_value_t = 50_000)]
    first_seed: u64,
    /// Only this scenario.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Another sea state than that of the scenario, 0 to 4.
    #[arg(long, value_name = "STATE")]
    sea_state: Option<u8>,
}

/// Prints the table. Returns whether every requirement holds.
///
/// # Errors
/// If a scenario cannot be loaded or simulated.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let seeds: Vec<u64> = (options.first_seed..options.first_seed + options.seeds).collect();
    print_line(&format!("{} trials a scenario, seeds from {}", options.seeds, options.first_seed));
    print_line(
        "scenario        marks    arrived  least m  < 2 m   held    at the person  honest   lost   other person   axis seen   off      heading  stern",
    );
    let mut is_met = true;
    for scenario in SCENARIOS {
        if options.only.as_ref().is_none_or(|only| scenario == only) {
            is_met &= run_scenario(scenario, options.sea_state, &seeds)?;
        }
    }
    print_line(if is_met { "\nevery requirement holds" } else { "\nrequirements are MISSED" });
    Ok(is_met)
}

fn run_scenario(scenario: &str, sea_state: Option<u8>, seeds: &[u64]) -> Result<bool> {
    let by_hand = trials(&plan(scenario, sea_state, Perception::Truth)?, seeds)?;
    let held = trials(&plan(scenario, sea_state, Perception::Pixels(TrackerName::Fused))?, seeds)?;
    let figures = held.iter().fold(Figures::default(), |sum, (_, figures)| sum.plus(*figures));
    print_line(&format!("{scenario:15} by hand  {}", guidance_cells(&by_hand)));
    print_line(&format!(
        "{scenario:15} held     {}  {:>5.1} %  {:>9.1} %  {:>6.2} %  {:>5.1} %  {:>6.2} %        {:>5.1} %  {:>5.1} %  {:>5.1} %  {:>5.1} %",
        guidance_cells(&held),
        100.0 * figures.held_share(),
        100.0 * figures.at_person_share(),
        100.0 * figures.honest_share(),
        100.0 * figures.lost_share(),
        100.0 * figures.wrong_share(),
        100.0 * figures.axis_share(),
        100.0 * figures.axis_off_share(),
        100.0 * figures.headed_share(),
        100.0 * figures.stern_share(),
    ));
    Ok(figures.honest_share() >= HONEST_SHARE && figures.wrong_share() <= WRONG_SHARE)
}

fn plan(scenario: &str, sea_state: Option<u8>, perception: Perception) -> Result<CampaignPlan> {
    CampaignPlan::new(&CampaignRequest {
        scenario: scenario.to_owned(),
        overrides: ScenarioOverrides { sea_state, ..ScenarioOverrides::default() },
        law: LawChoice::OPTIMAL,
        rate: None,
        guidance: Some(GuidanceLaw::LineOfSight),
        perception,
        plant: PlantName::Nominal,
        simd: SimdLevel::Avx512,
    })
    .with_context(|| format!("planning {scenario}"))
}

fn trials(plan: &CampaignPlan, seeds: &[u64]) -> Result<Vec<(GuidanceMetrics, Figures)>> {
    parallel::map(seeds, |seed| {
        let mut judge = Judge::new(plan.scenario().camera.optics);
        let log = plan.simulate(*seed, &mut judge)?;
        let guidance = plan.entry(*seed, &log).metrics.guidance.context("the trial measured no guidance")?;
        Ok((guidance, judge.figures()))
    })
    .into_iter()
    .collect()
}

fn guidance_cells(trials: &[(GuidanceMetrics, Figures)]) -> String {
    let closest = || trials.iter().filter_map(|(guidance, _)| guidance.closest_person_m);
    let stand_off_m = VesselProfile::SIMULATOR.stand_off_m;
    format!(
        "{:>7}  {:>7.1}  {:>5}",
        format!("{}/{}", trials.iter().filter(|(guidance, _)| guidance.arrived).count(), trials.len()),
        closest().fold(f64::INFINITY, f64::min),
        closest().filter(|closest| *closest < stand_off_m).count(),
    )
}
