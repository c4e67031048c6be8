//! `barrelman trials`: repeated simulated trials.

use std::io::{Write as _, stdout};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail};
use barrelman_trial::campaign::CampaignEntry;
use barrelman_trial::metrics::summarise;

use super::summary_table;
use crate::cli::{PerceptionName, TrialsArgs};
use crate::config::Configuration;
use crate::progress::Progress;
use barrelman_experiments::campaign::drive_inputs::DriveInputs;
use barrelman_experiments::campaign::file::CampaignWriter;
use barrelman_experiments::campaign::plan::CampaignRequest;
use barrelman_experiments::campaign::recording::TrialRecording;
use barrelman_experiments::campaign::runner::run_in_order;
use barrelman_experiments::campaign::{CampaignPlan, Perception};
use barrelman_experiments::drive::DriveReader;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;

/// Runs the command.
///
/// # Errors
/// If the campaign cannot be set up, a trial fails, or results cannot be written.
pub fn run(args: &TrialsArgs) -> Result<ExitCode> {
    let drive = args.drive.as_deref().map(DriveReader::read).transpose()?;
    let mut plan = CampaignPlan::new(&request(args, drive.as_ref())?)?;
    if let Some(drive) = &drive {
        plan = plan.with_drive(DriveInputs::of(drive));
    }
    if let Some(folder) = &args.record {
        let configuration =
            Configuration::simulated(plan.profile().clone(), plan.law(), plan.tracker())?.to_toml()?;
        plan = plan.recorded(TrialRecording {
            folder: folder.clone(),
            force: args.force || args.resume,
            configuration,
        })?;
    }
    let seeds = match &drive {
        Some(drive) => vec![drive.cast.url.seed],
        None => seeds(args)?,
    };
    let (mut writer, mut entries) = match &args.output {
        None if args.resume => bail!("--resume goes on with a file: name it with --output"),
        None => (None, Vec::new()),
        Some(path) if args.resume => {
            let (writer, entries) = CampaignWriter::resume(path, plan.settings(), &seeds)?;
            (Some(writer), entries)
        }
        Some(path) => (Some(CampaignWriter::create(path, args.force)?), Vec::new()),
    };
    let done = entries.len();
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).context("signals cannot be caught")?;
    }
    let progress = Progress::new("trials", seeds.len() as u64);
    progress.at(done as u64);
    let ran = run_in_order(
        &seeds[done..],
        args.threads.unwrap_or_else(cores),
        &stop,
        |seed| plan.run(seed),
        |entry: CampaignEntry| {
            if let Some(writer) = &mut writer {
                writer.add(&entry)?;
            }
            entries.push(entry);
            progress.at(entries.len() as u64);
            Ok(())
        },
    );
    progress.finish();
    ran?;
    let interrupted = stop.load(Ordering::Relaxed) && entries.len() < seeds.len();
    if interrupted {
        let go_on = if args.output.is_some() { "--resume goes on from here" } else { "nothing was kept" };
        tracing::error!("interrupted after {} of {} trials: {go_on}", entries.len(), seeds.len());
    }
    let summary = summarise(entries.into_iter().map(|entry| entry.trial).collect());
    let text =
        if args.json { serde_json::to_string_pretty(&summary)? + "\n" } else { summary_table::of(&summary)? };
    stdout().write_all(text.as_bytes())?;
    Ok(if interrupted { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// What is asked for; what is not said of a drive is as it was driven.
fn request(args: &TrialsArgs, drive: Option<&DriveReader>) -> Result<CampaignRequest> {
    let Some(scenario) = args.scenario.as_ref().or(drive.map(|drive| &drive.cast.url.scenario)) else {
        bail!("name a scenario, or a drive by --drive");
    };
    Ok(CampaignRequest {
        scenario: scenario.clone(),
        changes: ScenarioOverrides {
            setting: args.setting.clone(),
            boat_speed_m_per_s: args.boat_speed,
            sea_state: args.sea_state,
            wind_m_per_s: args.wind,
            size: args.size.or(drive.and_then(|drive| drive.cast.url.size)),
        },
        law: args.law.over(drive.map_or(LawChoice::SCHEMA, |drive| drive.cast.law))?,
        rate: args.rate,
        perception: match args.perception {
            PerceptionName::Truth => Perception::Truth,
            PerceptionName::Pixels => {
                let drive_inputs = drive.map(|drive| drive.cast.tracker);
                Perception::Pixels(args.tracker.or(drive_inputs).unwrap_or_default())
            }
        },
        plant: args.plant,
        simd: args.simd,
    })
}

/// The seeds of this shard, in order.
fn seeds(args: &TrialsArgs) -> Result<Vec<u64>> {
    let Some(end) = args.seed.checked_add(args.trials) else {
        bail!("--seed {} with --trials {} is beyond the largest seed", args.seed, args.trials);
    };
    let all = args.seed..end;
    Ok(match args.shard {
        None => all.collect(),
        Some(shard) => all.skip(shard.index - 1).step_by(shard.count).collect(),
    })
}

/// How many trials run at the same time unless something else is asked for.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
