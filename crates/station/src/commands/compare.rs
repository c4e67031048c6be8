//! `barrelman compare`: compares two campaigns, paired by seed.

use std::io::{Write as _, stdout};
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Result, bail};
use barrelman_experiments::campaign::file;
use barrelman_trial::campaign::statistics::Bootstrap;
use barrelman_trial::campaign::{CampaignComparison, CampaignSettings, SettingDifference};
use barrelman_trial::metrics::TrialEntry;

use super::comparison_table::ComparisonTable;
use crate::cli::CompareArgs;

/// Runs the command.
///
/// # Errors
/// If a file cannot be read, the campaigns have no trial in common, or their worlds differ without
/// `--anyway`.
pub fn run(args: &CompareArgs) -> Result<ExitCode> {
    let (first, second) = (Campaign::read(&args.first)?, Campaign::read(&args.second)?);
    let differences = first.settings.world_differences(&second.settings);
    if !differences.is_empty() {
        refuse_or_warn(args, &differences)?;
    }
    let comparison = CampaignComparison::new(&first.trials, &second.trials, &Bootstrap::DEFAULT);
    if comparison.pairs == 0 {
        bail!(
            "{} and {} have no trial in common: run both campaigns on the same scenario with the same --seed",
            args.first.display(),
            args.second.display()
        );
    }
    for (path, alone) in [(&args.first, &comparison.only_first), (&args.second, &comparison.only_second)] {
        if let Some(name) = alone.first() {
            tracing::warn!(
                "{} trials of {} have no partner and are left out, the first is {name}",
                alone.len(),
                path.display()
            );
        }
    }
    let text = if args.json {
        serde_json::to_string_pretty(&comparison)? + "\n"
    } else {
        let choices = first.settings.choice_differences(&second.settings);
        ComparisonTable { comparison: &comparison, files: (&args.first, &args.second), choices: &choices }
            .to_string()
    };
    stdout().write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses campaigns of different worlds, or with `--anyway` names what differs.
fn refuse_or_warn(args: &CompareArgs, differences: &[SettingDifference]) -> Result<()> {
    let named: Vec<String> = differences
        .iter()
        .map(|difference| format!("{}: {} and {}", difference.setting, difference.first, difference.second))
        .collect();
    let (first, second, named) = (args.first.display(), args.second.display(), named.join("; "));
    if args.anyway {
        tracing::warn!(
            "{first} and {second} are of different worlds ({named}): a difference need not be the law's"
        );
        return Ok(());
    }
    bail!(
        "{first} and {second} are of different worlds, so their trials are no pairs ({named}); run both campaigns with the \
         same options but for law and tracker, or give --anyway"
    );
}

/// A campaign's file, with the settings of all its trials.
struct Campaign {
    trials: Vec<TrialEntry>,
    settings: CampaignSettings,
}

impl Campaign {
    fn read(path: &Path) -> Result<Self> {
        let read = file::read(path)?;
        if read.is_truncated {
            tracing::warn!("{} ends within a line: the trials before it are used", path.display());
        }
        let Some((first, _)) = read.entries.first() else {
            bail!("{} holds no trial: run the campaign again with --output", path.display());
        };
        let settings = first.campaign.clone();
        if let Some(line) = read.entries.iter().position(|(entry, _)| entry.campaign != settings) {
            bail!(
                "{} holds trials of several campaigns: line {} has other settings than line 1; give each campaign a file \
                 of its own",
                path.display(),
                line + 1
            );
        }
        Ok(Self { trials: read.entries.into_iter().map(|(entry, _)| entry.trial).collect(), settings })
    }
}
