//! `barrelman metrics`: prints the metrics of each trial and of all trials together.

use std::process::ExitCode;

use anyhow::Result;
use barrelman_trial::metrics::{Arena, TrialEntry, measure, summarise};
use barrelman_vocab::VehicleProfile;

use super::trial_input::InputFile;
use super::{summary_table, trial_input};
use crate::cli::MetricsArgs;

/// Runs the command.
///
/// # Errors
/// If a log cannot be read.
pub fn run(args: &MetricsArgs) -> Result<ExitCode> {
    let shares = args.region.region.unwrap_or(VehicleProfile::fotokite_pro().region);
    let mut trials = Vec::with_capacity(args.logs.len());
    let mut is_truncated = false;
    for path in &args.logs {
        let mut input = match trial_input::read_any(path)? {
            InputFile::Trial(input) => *input,
            InputFile::Campaign(campaign) => {
                is_truncated |= campaign.report_truncation(path);
                args.region.refuse_for_campaign(path, args.picture.is_some())?;
                trials.extend(campaign.trials());
                continue;
            }
        };
        if let Some(frame) = args.region.frame_size {
            input.log.frame = frame;
        }
        if let Some(message) = &input.cut {
            tracing::error!("{message}");
            is_truncated = true;
        }
        let picture = args.picture.unwrap_or(input.log.picture);
        let metrics = measure(&input.log, input.log.region(shares), picture);
        let arena = args.arena.and_then(Arena::from_number).or_else(|| Arena::from_name(&input.name));
        trials.push(TrialEntry { name: input.name, arena, metrics });
    }
    let summary = summarise(trials);
    summary_table::print(&summary, args.json)?;
    Ok(if is_truncated { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
