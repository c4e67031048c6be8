//! The recorded trials of the laboratory, and simulated ones, as logs; and the figures that both are compared by.

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
use barrelman_trial::metrics::find_excursions;
use barrelman_vocab::VehicleProfile;

/// A recorded trial.
#[derive(Debug, Clone)]
pub(super) struct Recorded {
    /// What was logged.
    pub(super) log: TrialLog,
}

/// A place that moves by more than this from one row to the next was not the target's motion, pixels.
pub(super) const JUMP_PX: f64 = 25.0;

/// The trials of an arena in which the target was lost, as their rows show.
const LOST: [&[u32]; 2] = [&[11], &[3, 4]];

/// The recorded trials of an arena; those in which the target was lost are left out where asked.
pub(super) fn read(folder: &Path, arena: u8, with_lost: bool) -> Result<Vec<Recorded>> {
    let mut trials = Vec::new();
    for number in 1..=17 {
        let path = folder.join(format!("arena{arena}_{number:02}.csv"));
        if !path.exists() || (!with_lost && LOST[usize::from(arena) - 1].contains(&number)) {
            continue;
        }
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        trials.push(Recorded { log: logs::read_text(&text)?.log });
    }
    anyhow::ensure!(!trials.is_empty(), "{} holds no trial of arena {arena}", folder.display());
    Ok(trials)
}

/// The laboratory's scenario for an arena: the program's own, or the one in a folder.
pub(super) fn scenario(arena: u8, folder: Option<&Path>) -> Result<Scenario> {
    Ok(scenario::load(&scenario_name(arena, folder), &ScenarioOverrides::default())?.scenario)
}

fn scenario_name(arena: u8, folder: Option<&Path>) -> String {
    match folder {
        Some(folder) => folder.join(format!("lab{arena}.toml")).display().to_string(),
        None => format!("lab{arena}"),
    }
}

/// The laboratory's trials for an arena, with a law and where given another rate of the schema.
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
        perception: Perception::Truth,
        plant: PlantName::Nominal,
        simd: SimdLevel::Avx512,
    })
}

/// One simulated trial with the schema, perceived by truth.
pub(super) fn simulated(scenario: &Scenario, seed: u64) -> Result<TrialLog> {
    let mut profile = VehicleProfile::fotokite_pro();
    profile.video_latency = scenario.camera.latency();
    let world = World::new(scenario, seed).ok().context("the way-points make no path")?;
    let settings = PilotSettings { profile: profile.clone(), law: LawSettings::MotorSchema };
    let pilot = Pilot::new(settings, TrackerSettings::new(TrackerName::Camshift).build()?);
    Ok(Simulation::new(scenario, world, seed, pilot, &profile).run(None, &mut ()))
}

/// So many of them, with the seeds from `first` on.
pub(super) fn simulated_from(scenario: &Scenario, first: u64, count: u64) -> Result<Vec<TrialLog>> {
    (first..first + count).map(|seed| simulated(scenario, seed)).collect()
}

/// The region of the laboratory.
pub(super) fn region(log: &TrialLog) -> Region {
    log.region(VehicleProfile::fotokite_pro().region)
}

/// Names of [`Figures::values`].
pub(super) const FIGURES: [&str; 7] = [
    "duration, s",
    "excursions",
    "time outside, %",
    "duration of an excursion b, s",
    "height h",
    "sensitivity, 1/s",
    "integral of |rate|, rad",
];

/// The figures of one trial without the excursions in which the place jumped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Figures {
    /// As [`FIGURES`] names them; the last four are absent where no excursion was whole.
    pub(super) values: [Option<f64>; 7],
    /// The sensitivity with all excursions.
    pub(super) sensitivity_with_jumps: Option<f64>,
    /// Share of the excursions in which the place jumped.
    pub(super) excursions_with_jumps: usize,
}

/// Measures a trial.
pub(super) fn figures(log: &TrialLog) -> Figures {
    let all = find_excursions(log, region(log));
    let jumped = |first: usize, end: usize| {
        (first..=end.min(log.rows.len() - 1)).any(|row| row > 0 && step_px(log, row) > JUMP_PX)
    };
    let clean: Vec<_> = all.iter().filter(|excursion| !jumped(excursion.first, excursion.end)).collect();
    let whole: Vec<_> = clean.iter().filter(|excursion| excursion.is_complete).collect();
    let mean =
        |values: Vec<f64>| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    let outside_s: f64 = clean.iter().map(|excursion| excursion.b_s).sum();
    let travel: f64 = (0..log.rows.len())
        .filter(|row| !all.iter().any(|e| jumped(e.first, e.end) && (e.first..e.end).contains(row)))
        .filter_map(|row| {
            let rates = log.rows[row].rates?;
            let rate = rates.yaw.radians_per_second().abs() + rates.pitch.radians_per_second().abs();
            Some(rate * log.row_duration_s(row))
        })
        .sum();
    let complete: Vec<_> = all.iter().filter(|excursion| excursion.is_complete).collect();
    Figures {
        values: [
            Some(log.duration_s()),
            Some(clean.len() as f64),
            Some(100.0 * outside_s / log.duration_s()),
            mean(whole.iter().map(|excursion| excursion.b_s).collect()),
            mean(whole.iter().map(|excursion| excursion.h).collect()),
            mean(whole.iter().filter_map(|excursion| excursion.sensitivity()).collect()),
            Some(travel),
        ],
        sensitivity_with_jumps: mean(complete.iter().filter_map(|e| e.sensitivity()).collect()),
        excursions_with_jumps: all.len() - clean.len(),
    }
}

/// How far the place moved from the row before, pixels.
pub(super) fn step_px(log: &TrialLog, row: usize) -> f64 {
    match (log.rows[row - 1].position, log.rows[row].position) {
        (Some(before), Some(now)) => (now.x - before.x).hypot(now.y - before.y),
        _ => 0.0,
    }
}
