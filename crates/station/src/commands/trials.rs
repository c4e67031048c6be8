//! `barrelman trials`: runs a campaign of simulated trials.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use anyhow::{Result, bail};
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_trial::campaign::CampaignEntry;
use barrelman_trial::metrics::summarise;

use super::summary_table;
use super::trials_progress::{Campaign, TrialsProgress};
use crate::cli::{GuidedBy, PerceptionName, TrialsArgs, UsageError};
use crate::config::Configuration;
use crate::config::vessel::{GuidanceName, VesselConfig};
use crate::interruption::flag_of_signals;
use barrelman_experiments::campaign::drive_requests::DriveRequests;
use barrelman_experiments::campaign::file::CampaignWriter;
use barrelman_experiments::campaign::plan::CampaignRequest;
use barrelman_experiments::campaign::recording::TrialRecording;
use barrelman_experiments::campaign::runner::run_in_order;
use barrelman_experiments::campaign::{CampaignPlan, Perception};
use barrelman_experiments::drive::StoredDrive;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;

/// Runs the command.
///
/// # Errors
/// If the campaign cannot be set up, a trial fails, or results cannot be written.
pub fn run(args: &TrialsArgs) -> Result<ExitCode> {
    if args.tracker.is_some() && matches!(args.perception, PerceptionName::Truth) {
        return Err(UsageError(
            "--tracker has no effect with --perception truth: omit one of them".to_owned(),
        )
        .into());
    }
    let drive = args.drive.as_deref().map(StoredDrive::read).transpose()?;
    let mut plan = CampaignPlan::new(&request(args, drive.as_ref())?)?;
    if let Some(drive) = &drive {
        plan = plan.with_drive(DriveRequests::from_drive(drive));
    }
    if let Some(folder) = &args.record {
        plan = recorded_in(folder, plan, args, drive.as_ref())?;
    }
    let seeds = match &drive {
        Some(drive) => vec![drive.setup.url.seed],
        None => seeds(args)?,
    };
    let (mut writer, mut entries) = open_output(args, &plan, &seeds)?;
    let done_before = entries.len();
    let stop = flag_of_signals()?;
    if matches!(args.perception, PerceptionName::Pixels) {
        tracing::info!(
            "pictures are rendered and tracked, which takes about as long as the trials last; --perception truth \
             compares camera laws in seconds"
        );
    }
    let progress = TrialsProgress::start(Campaign {
        done_before: done_before as u64,
        trials: seeds.len() as u64,
        max_trial_s: plan.scenario().max_s,
        simulated: plan.simulated_time(),
        stop: Arc::clone(&stop),
    });
    let result = run_in_order(
        &seeds[done_before..],
        args.threads.unwrap_or_else(cores),
        &stop,
        |seed| plan.run(seed),
        |entry: CampaignEntry| {
            if let Some(writer) = &mut writer {
                writer.add(&entry)?;
            }
            progress.add(entry.trial.metrics.duration_s);
            entries.push(entry);
            Ok(())
        },
    );
    progress.finish();
    result?;
    let is_interrupted = stop.load(Ordering::Relaxed) && entries.len() < seeds.len();
    if is_interrupted {
        let remedy = if args.output.is_some() { "continue with --resume" } else { "no result was stored" };
        tracing::error!("interrupted after {} of {} trials: {remedy}", entries.len(), seeds.len());
    }
    let summary = summarise(entries.into_iter().map(|entry| entry.trial).collect());
    summary_table::print(&summary, args.json)?;
    Ok(if is_interrupted { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// The campaign with its trials recorded in a folder, each with the configuration of such a run.
fn recorded_in(
    folder: &Path,
    plan: CampaignPlan,
    args: &TrialsArgs,
    drive: Option<&StoredDrive>,
) -> Result<CampaignPlan> {
    let simulated = Configuration::simulated(plan.profile().clone(), plan.law(), plan.tracker())?;
    let commands_vessel = drive.is_some_and(|drive| drive.setup.commands_vessel());
    let guidance = match args.guidance {
        Some(GuidedBy::Lab) => GuidanceName::Lab,
        Some(GuidedBy::Los) | None => GuidanceName::Los,
    };
    let vessel = (commands_vessel || args.guidance.is_some())
        .then(|| VesselConfig { guidance, ..VesselConfig::simulated() });
    let configuration = Configuration { vessel, ..simulated }.to_toml()?;
    plan.with_recordings(TrialRecording {
        folder: folder.to_owned(),
        force: args.force || args.resume,
        configuration,
    })
}

/// Opens the file of results, if there is one, with the trials that it holds already.
fn open_output(
    args: &TrialsArgs,
    plan: &CampaignPlan,
    seeds: &[u64],
) -> Result<(Option<CampaignWriter>, Vec<CampaignEntry>)> {
    Ok(match &args.output {
        None if args.resume => bail!("--resume continues a file: name the file with --output"),
        None => (None, Vec::new()),
        Some(path) if args.resume => {
            let (writer, entries) = CampaignWriter::resume(path, plan.settings(), seeds)?;
            (Some(writer), entries)
        }
        Some(path) => (Some(CampaignWriter::create(path, args.force)?), Vec::new()),
    })
}

/// The campaign that the arguments describe. What they leave open is the drive's, if a drive is given.
fn request(args: &TrialsArgs, drive: Option<&StoredDrive>) -> Result<CampaignRequest> {
    let Some(scenario) = args.scenario.as_ref().or(drive.map(|drive| &drive.setup.url.scenario)) else {
        bail!("no scenario: name a scenario, or give a drive with --drive");
    };
    Ok(CampaignRequest {
        scenario: scenario.clone(),
        overrides: ScenarioOverrides {
            setting: args.setting.clone(),
            boat_speed_m_per_s: args.boat_speed,
            sea_state: args.sea_state,
            wind_m_per_s: args.wind,
            current_m_per_s: args.current,
            size: args.size.or(drive.and_then(|drive| drive.setup.url.size)),
        },
        law: args.law.resolve(drive.map_or(LawChoice::MOTOR_SCHEMA, |drive| drive.setup.law))?,
        rate: args.rate,
        guidance: args.guidance.map(GuidanceLaw::from),
        perception: match args.perception {
            PerceptionName::Truth => Perception::Truth,
            PerceptionName::Pixels => {
                let drive_tracker = drive.map(|drive| drive.setup.tracker);
                Perception::Pixels(args.tracker.or(drive_tracker).unwrap_or_default())
            }
        },
        plant: args.plant,
        simd: args.simd,
    })
}

/// The seeds of this shard, in order.
fn seeds(args: &TrialsArgs) -> Result<Vec<u64>> {
    let Some(end) = args.seed.checked_add(args.trials) else {
        bail!("--seed {} with --trials {} exceeds the largest seed", args.seed, args.trials);
    };
    let all = args.seed..end;
    Ok(match args.shard {
        None => all.collect(),
        Some(shard) => all.skip(shard.index - 1).step_by(shard.count).collect(),
    })
}

/// Default number of trials at the same time.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

impl From<GuidedBy> for GuidanceLaw {
    fn from(name: GuidedBy) -> Self {
        match name {
            GuidedBy::Los => Self::LineOfSight,
            GuidedBy::Lab => Self::Laboratory,
        }
    }
}
