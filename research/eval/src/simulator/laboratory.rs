//! Trials of the laboratory as logs: those that were recorded, and simulated ones of the same scenarios.

use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result};
use barrelman_control::Region;
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_pilot::{LawSettings, Pilot, PilotSettings};
use barrelman_sim::{Scenario, World};
use barrelman_simd::SimdLevel;
use barrelman_trial::campaign::Simulation;
use barrelman_trial::logs::{self, TrialLog};
use barrelman_trial::metrics::{TrialMetrics, measure};
use barrelman_vocab::VehicleProfile;

/// Largest number of a recorded trial.
const LAST_TRIAL: u32 = 17;

/// For each arena, the trials in which the tracker lost the target, as their rows show.
const TRIALS_WITH_LOSS: [&[u32]; 2] = [&[11], &[3, 4]];

/// The recorded trials of an arena (1 or 2); without `include_lost`, those in which the target was lost are
/// left out.
///
/// # Errors
/// If a file cannot be read, or no trial of the arena is in the folder.
pub(super) fn read_recorded(folder: &Path, arena: u8, include_lost: bool) -> Result<Vec<TrialLog>> {
    let mut trials = Vec::new();
    for number in 1..=LAST_TRIAL {
        let path = folder.join(format!("arena{arena}_{number:02}.csv"));
        let is_excluded = !include_lost && TRIALS_WITH_LOSS[usize::from(arena) - 1].contains(&number);
        if is_excluded || !path.exists() {
            continue;
        }
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        trials.push(logs::read_text(&text)?.log);
    }
    anyhow::ensure!(!trials.is_empty(), "{} holds no trial of arena {arena}", folder.display());
    Ok(trials)
}

/// The laboratory's scenario for an arena: the program's own, or the one in a folder.
///
/// # Errors
/// If the scenario cannot be loaded.
pub(super) fn load_scenario(arena: u8, folder: Option<&Path>) -> Result<Scenario> {
    Ok(scenario::load(&scenario_name(arena, folder), &ScenarioOverrides::default())?.scenario)
}

fn scenario_name(arena: u8, folder: Option<&Path>) -> String {
    match folder {
        Some(folder) => folder.join(format!("lab{arena}.toml")).display().to_string(),
        None => format!("lab{arena}"),
    }
}

/// Trials of an arena's scenario under a law; `rate` replaces the motor schema's rate, rad/s.
///
/// # Errors
/// If the scenario cannot be loaded.
pub(super) fn plan(
    arena: u8,
    folder: Option<&Path>,
    law: LawChoice,
    rate: Option<f64>,
) -> Result<CampaignPlan> {
    CampaignPlan::new(&CampaignRequest {
        scenario: scenario_name(arena, folder),
        overrides: ScenarioOverrides::default(),
        law,
        rate,
        guidance: None,
        perception: Perception::Truth,
        plant: PlantName::Nominal,
        simd: SimdLevel::Avx512,
    })
}

/// Simulates the trials of a plan and measures each.
///
/// # Errors
/// If a trial cannot be simulated.
pub(super) fn simulate_and_measure(plan: &CampaignPlan, seeds: Range<u64>) -> Result<Vec<TrialMetrics>> {
    seeds.map(|seed| Ok(measure_trial(&plan.simulate(seed, &mut ())?))).collect()
}

/// Simulates one trial with the motor schema, perceived by truth.
///
/// # Errors
/// If the scenario's way-points make no path.
pub(super) fn simulate(scenario: &Scenario, seed: u64) -> Result<TrialLog> {
    let mut profile = VehicleProfile::fotokite_pro();
    profile.video_latency = scenario.camera.latency();
    let world = World::new(scenario, seed).ok().context("the way-points make no path")?;
    let settings = PilotSettings { profile: profile.clone(), law: LawSettings::MotorSchema };
    let pilot = Pilot::new(settings, TrackerSettings::new(TrackerName::Camshift).build()?);
    Ok(Simulation::new(scenario, world, seed, pilot, &profile).run(None, &mut ()))
}

/// Simulates a trial for each seed, as [`simulate`].
///
/// # Errors
/// As [`simulate`].
pub(super) fn simulate_all(scenario: &Scenario, seeds: Range<u64>) -> Result<Vec<TrialLog>> {
    seeds.map(|seed| simulate(scenario, seed)).collect()
}

/// The region in which the target may roam, for the size of a log's picture.
pub(super) fn region(log: &TrialLog) -> Region {
    log.region(VehicleProfile::fotokite_pro().region)
}

/// The metrics of a trial in the laboratory's region.
pub(super) fn measure_trial(log: &TrialLog) -> TrialMetrics {
    measure(log, region(log), log.picture)
}
